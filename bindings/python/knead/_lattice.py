"""Lattices: the places of their control points, and derivatives with respect to their displacements, as arrays."""

import numpy as np

from ._knead import InvalidInput
from ._session import Session


def _box(stroke):
    if getattr(stroke, "tool", None) != "lattice" or stroke.file:
        raise InvalidInput("this takes a knead.Lattice that has its own displacements, not a file")
    return tuple(stroke.counts)


def _places(count, degree):
    """Returns where the control points of one edge lie, from 0 to 1."""
    degree = min(degree or count - 1, count - 1)
    knots = np.clip((np.arange(count + degree + 1) - degree) / (count - degree), 0, 1)
    return np.array([knots[i + 1 : i + 1 + degree].mean() for i in range(count)])


def lattice_points(stroke):
    """Returns the places of the control points of a knead.Lattice, an array (nx, ny, nz, 3): without displacements.

    They are even along each edge; with a `degree` they are closer at its ends. Displacements that are linear in these
    places move the box linearly, such as a turn: `turned(lattice_points(box)) - lattice_points(box)`.
    """
    counts = _box(stroke)
    axes = np.array(stroke.axes, dtype=np.float64)
    axes /= np.linalg.norm(axes, axis=1)[:, None]
    u = np.stack(np.meshgrid(*(_places(n, stroke.degree) for n in counts), indexing="ij"), axis=-1)
    return np.array(stroke.origin) + (u * np.array(stroke.lengths)) @ axes


def _session(stroke):
    numbers = np.array(stroke.displacements, dtype=np.float64).ravel()
    names = [f"d{i}" for i in range(numbers.size)]
    texts = np.array([f"${name}" for name in names]).reshape(-1, 3).tolist()
    return Session([{**stroke.to_dict(), "displacements": texts}], parameters=dict(zip(names, numbers.tolist())))


def lattice_jvp(stroke, points, direction, **options):
    """Returns the points that a knead.Lattice of the mode "spline" moves, and how they move with its displacements.

    direction: array-like (nx, ny, nz, 3), how the displacements change. options: the keywords of Session.jvp.
    Returns two arrays (n, 3). Raises InvalidInput as Session.jvp, which refuses the other modes.
    """
    counts = _box(stroke)
    direction = np.broadcast_to(np.asarray(direction, dtype=np.float64), (*counts, 3))
    return _session(stroke).jvp(points, direction.ravel().tolist(), **options)


def lattice_vjp(stroke, points, gradient, **options):
    """Returns the derivatives of a number with respect to the displacements of a knead.Lattice of the mode "spline".

    gradient: array-like (n, 3), the derivatives of the number with respect to the deformed points. options: the keywords
    of Session.vjp, but for `of_points`. Returns an array (nx, ny, nz, 3). Raises as lattice_jvp.
    """
    counts = _box(stroke)
    slopes = _session(stroke).vjp(points, gradient, **options)
    return None if slopes is None else np.array(list(slopes.values())).reshape(*counts, 3)
