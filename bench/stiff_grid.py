"""A flow that moves a rod in a pipe as nearly rigidly as it can, as strokes `grid` of a session: numbers that a script
computes. Needs numpy and scipy.

The field is v = curl A + grad p, and volumes may change: moving a rod aside in a narrow gap shears a mesh less if its
cells may shrink in front and grow behind. In the plane across the rod, A = (0, 0, a) and p minimise

    mean of stiffness (|shear|^2 + area |div v|^2) + weight * mean of |v - wanted|^2 on the rod, around its layers and on
    the wall

where shear is the traceless part of sym grad v, which is what turns cells out of their right angles. The stiffness falls
with the distance from the rod, so that the layers beside it move with it.
"""

import base64
import json

import numpy as np
import scipy.sparse as sparse
import scipy.sparse.linalg

_STEPS = 4  # strokes, each with a field of its own
_SAMPLES = 12000  # of the plane
_LAYERS = 30  # as stiff as this beside the rest are the layers
_AREA = 0.01  # of the change of areas, beside that of shear
_WEIGHT = 3e4  # of the wanted velocities, beside the mean diagonal of the strain times spacing^2


def _spline(t, order):
    """The cubic B-spline with its support from -2 to 2, or a derivative."""
    a, side = np.abs(t), np.sign(t)
    if order == 0:
        return np.where(a < 1, (4 - 6 * a**2 + 3 * a**3) / 6, np.maximum(2 - a, 0) ** 3 / 6)
    if order == 1:
        return side * np.where(a < 1, (9 * a**2 - 12 * a) / 6, -(np.maximum(2 - a, 0) ** 2) / 2)
    return np.where(a < 1, 3 * a - 2, np.maximum(2 - a, 0))


class _Plane:
    """A square of nodes around the origin that reaches beyond `size` to all sides."""

    def __init__(self, size, spacing):
        self.spacing = spacing
        self.count = 2 * int(np.ceil(size / spacing)) + 5
        self.first = -0.5 * (self.count - 1) * spacing

    def basis(self, points, x, y):
        """A row for each point: the derivatives, so many by x and y, of the nodes' splines."""
        at = (points - self.first) / self.spacing
        cell = np.floor(at).astype(int)
        rows, columns, values = [], [], []
        for i in range(-1, 3):
            for j in range(-1, 3):
                node = np.clip(cell + (i, j), 0, self.count - 1)
                rows.append(np.arange(len(points)))
                columns.append(node[:, 0] + self.count * node[:, 1])
                values.append(_spline(at[:, 0] - node[:, 0], x) * _spline(at[:, 1] - node[:, 1], y) / self.spacing ** (x + y))
        data = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        return sparse.csr_matrix(data, shape=(len(points), self.count**2))

    def velocity(self, points):
        """The matrices that give both components of v from the numbers a, then p, of all nodes."""
        return [sparse.hstack([self.basis(points, 0, 1), self.basis(points, 1, 0)]),
                sparse.hstack([-self.basis(points, 1, 0), self.basis(points, 0, 1)])]

    def strain(self, points, stiffness):
        """Returns the matrix of the mean of stiffness (|shear|^2 + area |div v|^2)."""
        mixed = self.basis(points, 1, 1)
        xx, yy = self.basis(points, 2, 0), self.basis(points, 0, 2)
        weights = sparse.diags(np.sqrt(stiffness / len(points)))
        shear = [sparse.hstack([2 * mixed, xx - yy]), sparse.hstack([yy - xx, 2 * mixed])]
        parts = [np.sqrt(0.5) * part for part in shear] + [np.sqrt(_AREA) * sparse.hstack([0 * mixed, xx + yy])]
        return sum((weights @ part).T @ (weights @ part) for part in parts)


def _solve(plane, body, stiffness, rows):
    matrix = plane.strain(body, stiffness)
    unit = matrix.diagonal().mean()
    right = np.zeros(matrix.shape[0])
    for points, wanted in rows:
        scale = _WEIGHT * unit * plane.spacing**2 / len(points)
        for part, value in zip(plane.velocity(points), wanted):
            matrix = matrix + part.T @ part * scale
            right += part.T @ np.full(len(points), value * scale)
    return scipy.sparse.linalg.spsolve((matrix + sparse.identity(len(right)) * (1e-9 * unit)).tocsc(), right)


def _stroke(plane, numbers, length):
    """The plane's numbers at all nodes along z, so that v does not depend on z from 0 to `length`."""
    spacing, count = plane.spacing, plane.count
    levels = int(np.ceil(length / spacing)) + 5
    a, p = numbers.reshape(2, 1, count, count)
    coefficients = np.zeros((levels, count, count, 3))
    coefficients[..., 2] = a
    text = [base64.b64encode(np.ascontiguousarray(v, "<f8").tobytes()).decode() for v in (coefficients, np.broadcast_to(p, (levels, count, count)))]
    return json.dumps({"tool": "grid", "origin": [plane.first, plane.first, -2 * spacing], "spacing": spacing,
                       "counts": [count, count, levels], "coefficients": text[0], "growth": text[1]})


def strokes(shift, rod, layers, pipe, length, spacing):
    """Returns lines of a session that move a rod by `shift` along x in a pipe, both along z from 0 to `length`.

    rod, layers, pipe: the radii of the rod, of its layers, and of the pipe.
    """
    plane = _Plane(pipe, spacing)
    samples = np.random.default_rng(0).uniform(-pipe, pipe, (_SAMPLES, 2))
    samples = samples[np.linalg.norm(samples, axis=1) < pipe]
    turn = np.linspace(0, 2 * np.pi, 300, endpoint=False)
    ring = np.column_stack([np.cos(turn), np.sin(turn)])
    rate = (shift / _STEPS, 0.0)
    lines = []
    for step in range(_STEPS):
        center = np.array([shift * (step + 0.5) / _STEPS, 0.0])
        distance = np.linalg.norm(samples - center, axis=1)
        is_body = distance > rod - spacing / 2
        stiffness = np.where(distance < layers + spacing / 2, _LAYERS, 1) / distance**2
        rows = [(ring * rod + center, rate), (ring * layers + center, rate), (ring * pipe, (0.0, 0.0))]
        lines.append(_stroke(plane, _solve(plane, samples[is_body], stiffness[is_body], rows), length))
    return "\n".join(lines)
