"""Lattices: the places of their control points, as an array."""

import numpy as np

from ._knead import InvalidInput


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
