"""Fits of one shape to another."""

import json
import operator

from . import _knead
from ._arrays import faces_for
from ._deform import _number, deform
from ._session import Session
from ._strokes import _wrap


class Fit:
    """A fit.

    session: a Session that takes the source to the target (the source scaled by report["scale"] about the middle of its
        box, where that is not 1). vertices: the source's, fitted: (n, 3) float64. also: the points given as `also`, moved
        along. report: a dict, the keys of `knead fit --json`.
    problem: why report["sound"] is false, in a sentence; empty if the fit is sound: nothing crosses that did not before,
        no triangle is stretched more than `max_stretch`, and landmarks are within their tolerance.
    """

    def __init__(self, session, vertices, also, report, problem):
        self.session = session
        self.vertices = vertices
        self.also = also
        self.report = report
        self.problem = problem

    def __repr__(self):
        distance = 100 * self.report["distance_after"]["mean"]
        return f"<knead.Fit: {len(self.session)} strokes, {distance:.2g}% of the diagonal apart{', ' + self.problem if self.problem else ''}>"


def _shape(shape, name):
    """Returns the vertices and faces of a mesh, or of a pair of both."""
    import numpy as np

    if isinstance(shape, (tuple, list)) and len(shape) == 2:
        return shape[0], faces_for(shape[0], shape[1])
    if isinstance(shape, np.ndarray):
        return shape, None
    if not hasattr(shape, "vertices") and not hasattr(shape, "points"):
        raise TypeError(f"{name} must be a shape or (vertices, faces), got {type(shape).__name__}")
    return shape, faces_for(shape)


def _points(shape):
    import numpy as np

    for name in ("vertices", "points"):
        if hasattr(shape, name):
            shape = getattr(shape, name)
            break
    return np.asarray(shape, dtype=float)


def _numbered(rows, column, points, whose):
    import numpy as np

    numbers = rows[:, column]
    if (numbers != np.floor(numbers)).any() or (numbers < 0).any() or (numbers >= len(points)).any():
        raise _knead.InvalidInput(f"pairs must name vertices of the {whose}, from 0 to {len(points) - 1}")
    return points[numbers.astype(int)]


def _pairs(pairs, source, target, name):
    """Returns rows of a point, its place and a tolerance: (n, 7)."""
    import numpy as np

    if pairs is None:
        return np.zeros((0, 7))
    rows = np.asarray(pairs, dtype=float)
    if rows.ndim == 3 and rows.shape[0] == 2 and rows.shape[2] == 3:
        rows = np.concatenate([rows[0], rows[1]], axis=1)
    if rows.size == 0:
        return np.zeros((0, 7))
    if rows.ndim != 2 or rows.shape[1] not in (2, 3, 6, 7):
        raise _knead.InvalidInput(
            f"{name} must be (n, 2) vertices, or (n, 6) places, each with a further column of tolerances or without, "
            f"got {rows.shape}"
        )
    if not np.isfinite(rows).all():
        raise _knead.InvalidInput(f"{name} holds a number that is not finite, in row {int(np.argmin(np.isfinite(rows).all(axis=1)))}")
    if rows.shape[1] < 6:
        places = [_numbered(rows, 0, _points(source), "source"), _numbered(rows, 1, _points(target), "target")]
        rows = np.concatenate([*places, rows[:, 2:]], axis=1)
    return rows if rows.shape[1] == 7 else np.concatenate([rows, np.zeros((len(rows), 1))], axis=1)


def fit(
    source,
    target,
    landmarks=None,
    map=None,
    *,
    volume="keep",
    align=True,
    surface=True,
    partial=False,
    also=(),
    max_stretch=5,
    threads=0,
    progress=None,
):
    """Fits one shape to another by a flow that strains the body least, and returns a Fit.

    source, target: shapes, or (vertices, faces).
    landmarks: points of the source and their places on the target, met exactly, or to a tolerance: (n, 2) numbers of
        vertices or (n, 6) coordinates; a further column holds tolerances, lengths. At most 2000.
    map: pairs of the same form, of any number: a start that need not be right everywhere. Without it vertices of
        the same number are pairs where both shapes have the same faces and surface is True, unless landmarks, max_stretch or
        a volume that stays say otherwise.
    volume: "keep"; "total": the source is scaled to the target's volume first; "free": it grows and shrinks on purpose
        where the target asks for it, smoothly: report["det_least"] and ["det_greatest"] say how much.
    align: True moves the source as a whole first where that brings it much nearer; "always"; False never.
    surface: brings the whole surface to the target's; False: landmarks and map alone.
    partial: matches only what both surfaces have; what faces a hole or a cut of the other one is left alone, and
        report["matched"] says how much of the source was matched.
    also: further points, arrays (n, 3), that move along.
    max_stretch: what a triangle may be stretched; Fit.problem says where that is exceeded.
    progress: as for deform. If it returned False, fit returns None.

    Raises InvalidInput for input that cannot be used: pairs that contradict each other, mirror images, shapes without
    faces or, to be scaled, without a volume.
    """
    import numpy as np

    of_source, of_target = _shape(source, "source"), _shape(target, "target")
    alignment = {True: "auto", False: "never"}.get(align, align) if isinstance(align, bool) else str(align)
    request = _knead.FitRequest(
        _pairs(landmarks, of_source[0], of_target[0], "landmarks"),
        _pairs(map, of_source[0], of_target[0], "map"),
        bool(surface),
        bool(partial),
        alignment,
        str(volume),
        _number(max_stretch, "max_stretch"),
        operator.index(threads),
    )
    result = _knead.fit(of_source, of_target, request, progress)
    if result is None:
        return None
    strokes, vertices, report, problem = result
    session = Session()
    session._strokes = [_wrap(s) for s in strokes]
    report = json.loads(report)
    points = _points(of_source[0])
    low, high = points.min(axis=0), points.max(axis=0)
    middle, size = (low + high) / 2, report["scale"] * float(np.linalg.norm(high - low))
    moved = [
        deform(middle + (_points(other) - middle) * report["scale"], session, diagonal=size, threads=threads)
        for other in also
    ]
    return Fit(session, vertices, moved, report, problem)
