"""A tank holds a fifth more while a dent keeps its wall clear of a beam; as little sheet metal as possible.

The optimiser changes the tank's width and height and the depth of the dent. The volume is held, the clearance is bounded, the
area is the objective; all three have exact gradients. Needs numpy and scipy.
"""

import numpy as np
from scipy.optimize import minimize

import knead

CLEARANCE = 0.05


def ball(rows=24, columns=36):
    """The vertices and triangles of a ball of radius 1."""
    u, v = np.meshgrid(np.linspace(0, np.pi, rows + 1)[1:-1], np.linspace(0, 2 * np.pi, columns, endpoint=False), indexing="ij")
    points = np.column_stack([(np.sin(u) * np.cos(v)).ravel(), (np.sin(u) * np.sin(v)).ravel(), np.cos(u).ravel()])
    at = lambda i, j: i * columns + j % columns
    faces = [t for i in range(rows - 2) for j in range(columns)
             for t in ([at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)])]
    top, bottom = len(points), len(points) + 1
    faces += [t for j in range(columns) for t in ([top, at(0, j), at(0, j + 1)], [bottom, at(rows - 2, j + 1), at(rows - 2, j)])]
    return np.vstack([points, [[0, 0, 1], [0, 0, -1]]]), np.array(faces)


tank, faces = ball()
beam = np.array([[1.0, -3, 0.1], [1.0, 3, 0.1], [1.0, 3, -0.1], [1.0, -3, -0.1]])  # the side that faces the tank
beam_faces = len(tank) + np.array([[0, 1, 2], [0, 2, 3]])
near = np.flatnonzero((tank[:, 0] > 0.8) & (np.abs(tank[:, 1]) < 0.5))
pull = {"tool": "implicit", "path": [[1.1, 0, 0], ["$depth", 0, 0]], "inner": 0.2, "outer": 0.8}
dent = knead.Session([pull], parameters={"depth": 1.0})
scales = np.array([[1.0, 1, 0], [0, 0, 1]])  # of x, y and z by width and height


def shape(values):
    """The tank's points, and a function from their gradient to that with respect to width, height and depth."""
    undented = tank * (scales.T @ values[:2])
    session = dent(depth=values[2])

    def gradient(of_points):
        of_undented, of_depth = session.vjp(undented, of_points, of_points=True, relative_tolerance=1e-7, diagonal=4)
        return np.append(scales @ (of_undented * tank).sum(axis=0), of_depth["depth"])

    return knead.deform(undented, session, precision="float64", relative_tolerance=1e-8, diagonal=4), gradient


def measured(measure):
    """A function of the values and its gradient, of a measure of the tank's points."""

    def fun(values):
        return float(measure(shape(values)[0]))

    def jac(values):
        points, gradient = shape(values)
        return gradient(measure(points).vjp()[: len(tank)])

    return {"fun": fun, "jac": jac}


def clearance(values):
    points, _ = shape(values)
    return knead.patch_distance(np.vstack([points, beam]), near, beam_faces).values - CLEARANCE


def clearance_slopes(values):
    points, gradient = shape(values)
    distances = knead.patch_distance(np.vstack([points, beam]), near, beam_faces)
    return np.array([gradient(distances.vjp(row)[: len(tank)]) for row in np.eye(len(near))])


area = measured(lambda points: knead.area_of(points, faces))
volume = measured(lambda points: knead.volume_of(points, faces))
start = np.array([1.0, 1.0, 1.0])
wanted = 1.2 * volume["fun"](start)
found = minimize(
    area["fun"], start, jac=area["jac"], method="SLSQP", bounds=[(0.8, 1.5), (0.8, 1.5), (0.7, 1.09)],
    options={"ftol": 1e-9, "maxiter": 60},
    constraints=[{"type": "eq", "fun": lambda v: volume["fun"](v) - wanted, "jac": volume["jac"]},
                 {"type": "ineq", "fun": clearance, "jac": clearance_slopes}])
held, free = volume["fun"](found.x) / wanted - 1, clearance(found.x).min() + CLEARANCE
print(f"width {found.x[0]:.4f}, height {found.x[1]:.4f}, depth {found.x[2]:.4f}: area {found.fun:.4f}, "
      f"volume off by {held:.1e}, clearance {free:.4f}; {found.message}")
