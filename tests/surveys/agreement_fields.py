"""The fields of the method, at many points at once: motions, regions and their velocity. For check_agreement.py."""
import numpy as np


# Fields: v = w u + (dw/dr) grad r x A -----------------------------------------------------------------

def unit(a):
    a = np.asarray(a, float)
    return a / np.sqrt(a @ a)


def dot(a, b):
    return (a * b).sum(-1)


def cross(a, b):
    a, b = np.broadcast_arrays(a, b)
    return np.stack([a[..., 1] * b[..., 2] - a[..., 2] * b[..., 1],
                     a[..., 2] * b[..., 0] - a[..., 0] * b[..., 2],
                     a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]], -1)


def turned(v, axis, angle):
    return v * np.cos(angle) + np.cross(axis, v) * np.sin(angle) + axis * (axis @ v) * (1 - np.cos(angle))


def assembled(r, grad, u, a, inner, outer):
    s = np.clip((r - inner) / (outer - inner), 0, 1)
    b = 4 * s**3 - 3 * s**4
    w = (1 - b) ** 2
    slope = -2 * (1 - b) * 12 * s * s * (1 - s) / (outer - inner)
    return w[:, None] * u + slope[:, None] * cross(grad, a)


def ball(x, c):
    d = x - c
    r = np.sqrt(dot(d, d))
    return r, d / np.where(r > 0, r, 1)[:, None]


def capsule(x, c, h):
    d = x - c
    s = np.clip(d @ h / (h @ h), -1, 1)
    return ball(d, s[:, None] * h)


def curve(x, polyline):
    """(3/4 sum of the integrals of |x-y|^-5)^(-1/4) and its gradient, by Gauss-Legendre quadrature in z,
    l = h sinh z: the integrand is then h^-4 cosh^-4 z, smooth and at most 1, wherever x lies. Beyond an end
    and near the line the panels follow l itself, on which the distance at most doubles."""
    total, slope = np.zeros(len(x)), np.zeros_like(x)
    nodes, weights = np.polynomial.legendre.leggauss(20)
    for p, q in zip(polyline[:-1], polyline[1:]):
        length = np.sqrt((q - p) @ (q - p))
        e = (q - p) / length
        foot = (x - p) @ e
        across = x - p - foot[:, None] * e
        h = np.maximum(np.sqrt(dot(across, across)), 1e-9 * length)  # a vertex may lie on the curve
        low, high = -foot, length - foot
        side = np.where(low > 0, 1.0, np.where(high < 0, -1.0, 0.0))
        plain = (side != 0) & (h < 3 * np.minimum(abs(low), abs(high)))
        for chosen in (~plain, plain):
            index = np.flatnonzero(chosen)
            if len(index) == 0:
                continue
            along, hh = side[index], h[index]
            if chosen is plain:
                a, b = np.log(np.minimum(abs(low), abs(high))[index]), np.log(np.maximum(abs(low), abs(high))[index])
            else:
                a, b = np.arcsinh(low[index] / hh), np.arcsinh(high[index] / hh)
            panels = max(1, int(np.ceil((b - a).max() / 1.0)))
            for k in range(panels):
                z = (a + (b - a) * k / panels)[:, None] + ((b - a) / panels)[:, None] * (nodes + 1) / 2
                dz = ((b - a) / panels / 2)[:, None] * weights
                if chosen is plain:
                    l, dl = along[:, None] * np.exp(z), np.exp(z) * dz
                else:
                    l, dl = hh[:, None] * np.sinh(z), hh[:, None] * np.cosh(z) * dz
                rr = np.sqrt(hh[:, None] ** 2 + l * l)
                total[index] += (dl * rr**-5).sum(1)
                seven = dl * rr**-7
                slope[index] -= 5 * (seven.sum(1)[:, None] * across[index] - (seven * l).sum(1)[:, None] * e)
    r = (0.75 * total) ** -0.25
    return r, (-0.25 * r**5 * 0.75)[:, None] * slope


def point_set(x, points, curves, m):
    rs, grads = [], []
    for p in points:
        r, g = ball(x, p)
        rs.append(r)
        grads.append(g)
    for line in curves:
        r, g = curve(x, line)
        rs.append(r)
        grads.append(g)
    rs, grads = np.array(rs), np.array(grads)
    least = rs.min(0)
    on = least == 0
    ratio = np.where(on, 1, least) / np.where(rs == 0, 1, rs)
    r = least * (ratio**m).sum(0) ** (-1.0 / m)
    grad = (((r / np.where(rs == 0, 1, rs)) ** (m + 1))[:, :, None] * grads).sum(0)
    return r, np.where(on[:, None], 0, grad)
