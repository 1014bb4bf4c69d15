"""From a pointer to strokes: what it touches, where a part begins, dabs of paint, images in mirrors."""

from . import _knead
from ._arrays import faces_for
from ._strokes import Stroke, _wrap, stroke


class Surface:
    """A surface that a pointer touches, to place strokes on it.

    vertices: (n, 3); faces: as for deform. Takes about 0.3 us a triangle. Points and directions are three numbers;
    a direction has any length but 0.
    """

    def __init__(self, vertices, faces=None):
        self._native = _knead.Surface(vertices, faces_for(vertices, faces))

    def __reduce__(self):
        return Surface, (self._native.vertices(), self._native.faces())

    def move(self, vertices):
        """Moves the vertices, as many as before; takes less time than a new surface."""
        self._native.move(vertices)

    def hit(self, origin, direction):
        """Returns the point where a ray first meets the surface, and the unit normal there; None where it misses."""
        return self._native.hit(origin, direction)

    def middle(self, origin, direction):
        """Returns the point halfway between where a ray enters the shape and where it leaves it; None where it misses."""
        return self._native.middle(origin, direction)

    def thickness(self, point, normal):
        """Returns how thick the shape is under a point of the surface, against the normal; None where it is open there."""
        return self._native.thickness(point, normal)

    def ring(self, point, normal, radius, count=64):
        """Returns a ring of about that radius around the normal at a point, on the surface where that is near: (count, 3)."""
        return self._native.ring(point, normal, radius, count)

    def part(self, point, direction, *, axis=(0, 0, 0), angle_deg=0):
        """Returns keys of a twist or bend that moves one part alone: center, normal, inner, outer and radius.

        point: inside the part. direction: along the part, towards its tip. axis, angle_deg: of a bend whose sweep must
        reach nothing else, if possible. Raises InvalidInput where there is no such place, with the reason.
        """
        return self._native.part(point, direction, axis, angle_deg)

    def with_safe_zone(self, stroke):
        """Returns a twist or bend with its zone widened where it is too thin for the angle; another stroke as it is."""
        return _wrap(self._native.with_safe_zone(stroke._native))


class PaintDrag:
    """Painting with a pointer: dabs at even distances along the places that it touches.

    Each dab is where the dabs before it have moved its place, so the result does not depend on the pointer's speed.
    outer: the radius of a dab, or its bump with the falloff "wide". depth: of a whole layer, as the key of the stroke:
    below 0 it pulls the surface out. pinch: of a whole layer with the falloff "wide", from -5 to 5. surface: the Surface as it
    was before the painting, to whose mean planes a pinch below 0 flattens; without it, to planes through the places touched.
    """

    def __init__(self, *, outer, depth, falloff=4, pinch=0.0, surface=None):
        wide = falloff == "wide"
        self._native = _knead.PaintDrag(outer, depth, 4 if wide else falloff, wide, pinch, surface and surface._native)

    def __reduce__(self):
        raise TypeError("a PaintDrag cannot be copied or pickled; send its strokes")

    def touch(self, point, normal, *, outer=None, pressure=1.0):
        """Goes on to a place of the surface as it was before the painting; steps longer than `spacing` lose dabs.

        outer: the radius here. pressure: how much the way to this place counts, above 0 and at most 1.
        """
        self._native.touch(point, normal, outer, pressure)

    def finish(self):
        """Ends the painting; a single dab gets the full depth."""
        self._native.finish()

    @property
    def spacing(self):
        """The distance of dabs at full pressure."""
        return self._native.spacing()

    @property
    def strokes(self):
        """The strokes so far; later ones are the same with more samples, or more strokes."""
        return [_wrap(s) for s in self._native.strokes()]


def brush(name, path, *, radius, amount=None):
    """Returns the stroke of a brush of a sculptor: Implicit for "move" and "snakehook", else Paint.

    name: "move", "snakehook", "paint", "crease", "pinch" or "flatten". path: points; of a pull the first is on the surface and
    2 or more, of paint all are near it. radius: of the bump, above 0; its return reaches four times as far. amount, of paint:
    how high a layer is, relative to the radius, else the logarithm by which it pinches; below 0 it does the contrary. None:
    what suits as a rule. Raises InvalidInput for another name.
    """
    return _wrap(_knead.brush(name, [[float(x) for x in point] for point in path], radius, amount))


def symmetric(strokes, planes, *, size=None, image_file=None):
    """Returns strokes that act together with their images in coordinate planes through the origin, such as "x" or "xz".

    Each keeps its keys and gets the key `mirror`: the stroke and its images act at the same time, points of a plane stay
    in it exactly, and an image that is the stroke itself counts once. A relax gets the images of its points. size and
    image_file are not used any more: images need neither.
    """
    if isinstance(strokes, (Stroke, dict)):
        strokes = [strokes]
    unknown = set(planes) - set("xyz")
    if unknown:
        raise _knead.InvalidInput(f'planes must be some of "x", "y" and "z", got {planes!r}')
    native = _knead.symmetric([stroke(s)._native for s in strokes], "".join(sorted(set(planes))))
    return [_wrap(s) for s in native]
