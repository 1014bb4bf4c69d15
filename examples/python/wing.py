"""A wing gets camber for a wanted lift, while its spars stay as thick and its tanks as large; as little area as possible.

A lattice of 7 by 3 by 2 control points moves the wing up and down, and all derivatives come from one call of `Flow.vjp`. The
optimiser's numbers are how pairs of control points move together and apart: pairs that cannot meet never fold the box. The
lift is that of thin airfoils without incidence, by the camber at nine stations. Needs numpy and scipy.
"""

import numpy as np
from scipy.optimize import minimize

import knead

LIFT = 0.5
STATIONS = 9  # along the span
CHORD = 30  # places from the nose to the tail, at which the upper and the lower side have a vertex

# The profile NACA 0012 with a sharp tail; x = (1 - cos theta) / 2.
theta = np.linspace(0, np.pi, CHORD + 1)
x = (1 - np.cos(theta)) / 2
half = 0.6 * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
half[[0, -1]] = 0


def wing():
    """The vertices and triangles, and the numbers of the vertices of the upper and the lower side: (STATIONS, CHORD + 1)."""
    ring = np.concatenate([np.column_stack([x, half]), np.column_stack([x, -half])[-2:0:-1]])
    points = np.concatenate([np.insert(ring, 1, y, axis=1) for y in np.linspace(0, 2, STATIONS)])
    count = len(ring)
    at = lambda station, i: station * count + i % count
    faces = [t for s in range(STATIONS - 1) for i in range(count)
             for t in ([at(s, i), at(s + 1, i + 1), at(s + 1, i)], [at(s, i), at(s, i + 1), at(s + 1, i + 1)])]
    for station, side in ((0, -1), (STATIONS - 1, 1)):
        for i in range(CHORD):  # between the upper and the lower side
            a, b, c, d = (at(station, k) for k in (i, i + 1, count - i - 1, count - i))
            faces += [t[::side] for t in ([a, b, c], [a, c, d]) if len(set(t)) == 3]
    upper = np.array([[at(s, i) for i in range(CHORD + 1)] for s in range(STATIONS)])
    lower = np.array([[at(s, count - i) for i in range(CHORD + 1)] for s in range(STATIONS)])
    return points, np.array(faces), upper, lower


points, faces, upper, lower = wing()
spars = np.unique(upper[:, [np.abs(x - at).argmin() for at in (0.25, 0.6)]])
box = {"origin": [-0.02, -0.02, -0.1], "lengths": [1.04, 2.04, 0.2], "mode": "spline"}
shape = (7, 3)  # of the pairs of control points

# The lift is linear in z: 2 times the integral of slope (cos theta - 1) d theta, the mean of the stations.
by_slope = 2 * (np.cos((theta[1:] + theta[:-1]) / 2) - 1) * np.diff(theta) / np.diff(x)
of_camber = np.append(0, by_slope) - np.append(by_slope, 0)
lift_slopes = np.zeros_like(points)
for side in (upper, lower):
    np.add.at(lift_slopes[:, 2], side.ravel(), np.tile(of_camber, STATIONS) / (2 * STATIONS))


def flow_of(values):
    together, apart = values.reshape(2, *shape)
    displacements = np.zeros((*shape, 2, 3))
    displacements[..., 0, 2], displacements[..., 1, 2] = together - apart, together + apart
    return knead.Flow(knead.Lattice(**box, displacements=displacements))


def measured(measure):
    """The values of a measure of the wing's points, and their derivatives, as functions for an optimiser."""

    def jac(values):
        flow = flow_of(values)
        found = measure(flow(points, precision="float64"))
        slopes = [flow.vjp(points, found.vjp(row))[1][0][..., 2] for row in np.eye(np.size(found.values))]
        return np.squeeze([np.concatenate([(s[..., 0] + s[..., 1]).ravel(), (s[..., 1] - s[..., 0]).ravel()]) for s in slopes])

    return {"fun": lambda values: np.squeeze(measure(flow_of(values)(points, precision="float64")).values), "jac": jac}


class Lift:
    def __init__(self, points):
        self.values = np.sum(lift_slopes * points)

    def vjp(self, weights):
        return lift_slopes * weights


lift = measured(Lift)
area = measured(lambda points: knead.area_of(points, faces))
volume = measured(lambda points: knead.volume_of(points, faces))
thickness = measured(lambda points: knead.thickness_at(points, spars, faces))
start = np.zeros(2 * np.prod(shape))
thick, full = thickness["fun"](start), volume["fun"](start)
found = minimize(
    area["fun"], start, jac=area["jac"], method="SLSQP", bounds=[(-0.5, 0.5)] * (len(start) // 2) + [(-0.08, 0.08)] * (len(start) // 2),
    options={"ftol": 1e-8, "maxiter": 200},
    constraints=[{"type": "eq", "fun": lambda v: lift["fun"](v) - LIFT, "jac": lift["jac"]},
                 {"type": "ineq", "fun": lambda v: volume["fun"](v) / full - 1, "jac": lambda v: volume["jac"](v) / full},
                 {"type": "ineq", "fun": lambda v: thickness["fun"](v) - 0.99 * thick, "jac": thickness["jac"]}])
print(f"lift {lift['fun'](found.x):.4f}, volume {volume['fun'](found.x) / full:.5f}, thinnest spar "
      f"{(thickness['fun'](found.x) / thick).min():.4f}, area {found.fun / area['fun'](start):.5f} of before; {found.message}")
if __name__ == "__main__":
    knead.write("wing.ply", flow_of(found.x)(points, precision="float64"), faces)
