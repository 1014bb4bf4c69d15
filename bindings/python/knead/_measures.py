"""Measures of a surface with their derivatives by its points: constraints of an optimiser."""

import operator

from . import _knead
from ._arrays import faces_for


class Measure:
    """Numbers measured on a surface of n points, with their derivatives with respect to these.

    values: (k,) float64. A measure of one number is also a float: float(knead.volume_of(...)).
    """

    def __init__(self, native):
        self._native = native

    @property
    def values(self):
        """The measured numbers, (k,) float64."""
        return self._native.values

    def jvp(self, tangents):
        """Returns how fast the values change, (k,) float64, where the points move by tangents: array-like (n, 3).

        Raises InvalidInput for another number of points.
        """
        return self._native.jvp(tangents)

    def vjp(self, weights=1.0):
        """Returns the gradient, (n, 3) float64, with respect to the points, of the sum of weights times values.

        weights: array-like (k,), or one number for all. Raises InvalidInput for another number of weights.
        """
        import numpy as np

        weights = np.asarray(weights, dtype=float)
        if weights.ndim == 0:
            weights = np.full(len(self.values), weights)
        return self._native.vjp([float(weight) for weight in weights.ravel()])

    def __float__(self):
        values = self.values
        if len(values) != 1:
            raise TypeError(f"the measure has {len(values)} values; use .values")
        return float(values[0])

    def __len__(self):
        return len(self.values)

    def __repr__(self):
        return f"<knead.Measure: {float(self):.6g}>" if len(self) == 1 else f"<knead.Measure: {len(self)} values>"


def _vertices(at):
    import numpy as np

    numbers = np.asarray(at)
    if numbers.dtype == bool:
        numbers = np.flatnonzero(numbers)
    numbers = [operator.index(vertex) for vertex in numbers.ravel()]
    wrong = [vertex for vertex in numbers if not 0 <= vertex < 2**32]
    if wrong:
        raise _knead.InvalidInput(f"vertex {wrong[0]} does not exist")
    return numbers


def volume_of(vertices, faces=None):
    """Returns a Measure of one number: the volume within a closed surface, in cubed units of length.

    vertices: array-like (n, 3), or a mesh. faces: (m, k) or a list of lists, counter-clockwise seen from outside; not
        needed for a mesh.

    Raises InvalidInput for an open surface.
    """
    return Measure(_knead.volume_of(vertices, faces_for(vertices, faces)))


def area_of(vertices, faces=None):
    """Returns a Measure of one number: the area of a surface, in squared units of length. Arguments: as for volume_of."""
    return Measure(_knead.area_of(vertices, faces_for(vertices, faces)))


def thickness_at(vertices, at, faces=None):
    """Returns a Measure of the wall thickness at some vertices: the distance along the inward normal to the other side.

    at: the numbers of k vertices, or a mask (n,) of bool. The others: as for volume_of. The derivative takes the normal's
    turning into account. It jumps where the ray passes from one face to the next; the thickness does not.

    Raises InvalidInput where there is no other side, and for a number that is no vertex.
    """
    return Measure(_knead.thickness_at(vertices, faces_for(vertices, faces), _vertices(at)))


def curvature(vertices, at, faces=None):
    """Returns a Measure of the mean curvature at some vertices, per unit of length: 1/r on a sphere, below 0 in hollows.

    Arguments: as for thickness_at. From the cotangent Laplacian, so it needs triangles of moderate angles.

    Raises InvalidInput at a border, beside a face without area, and for a number that is no vertex.
    """
    return Measure(_knead.curvature_at(vertices, faces_for(vertices, faces), _vertices(at)))


def patch_distance(vertices, at, patch):
    """Returns a Measure of the distances of some vertices from a patch, in units of length.

    vertices: array-like (n, 3), or a mesh. at: as for thickness_at, such as the vertices of another patch. patch: the
    faces of the patch, (m, k) or a list of lists of numbers of the same vertices. The derivative of a distance of 0 is 0.

    Raises InvalidInput for a patch without faces, and for a number that is no vertex.
    """
    return Measure(_knead.patch_distance(vertices, faces_for(vertices, patch), _vertices(at)))
