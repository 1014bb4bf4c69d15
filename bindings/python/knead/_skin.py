"""Characters: shapes that hang on skeletons."""

import json
import operator

from . import _knead
from ._arrays import faces_for
from ._deform import _number
from ._session import Session
from ._strokes import _wrap


class Posed:
    """A pose.

    vertices: the posed shape, (n, 3) float64. session: a Session that takes the shape at rest to it. report: a dict, the
    keys of `knead skin --json`: volume, crossings and stretch of linear blend ("linear"), dual quaternions ("dual") and
    this pose ("flow"). linear, dual: the vertices of these two. corrective: the rest shape that linear blend takes to
    `vertices`; without the rest vertices it is a morph target.
    """

    def __init__(self, vertices, session, report, linear, dual, corrective):
        self.vertices = vertices
        self.session = session
        self.report = report
        self.linear = linear
        self.dual = dual
        self.corrective = corrective

    def __repr__(self):
        flow = self.report["flow"]
        volume = "no volume" if flow["volume_error"] is None else f"volume {100 * flow['volume_error']:+.2g}%"
        return f"<knead.Posed: {len(self.session)} strokes, {volume}, {flow['crossings_new']} new crossings>"


def _rows(weights, vertices):
    """Returns begin, bones and weights of sparse rows: of a dense array, a scipy matrix, or (bones, weights)."""
    import numpy as np

    if hasattr(weights, "tocsr"):
        rows = weights.tocsr()
        if rows.shape[0] != vertices:
            raise _knead.InvalidInput(f"weights has {rows.shape[0]} rows for {vertices} vertices")
        return np.asarray(rows.indptr), np.asarray(rows.indices), np.asarray(rows.data, dtype=float)
    if isinstance(weights, tuple) and len(weights) == 2:
        bones, values = np.asarray(weights[0]), np.asarray(weights[1], dtype=float)
        if bones.ndim != 2 or bones.shape != values.shape or bones.dtype.kind not in "iu":
            raise _knead.InvalidInput("weights as (bones, weights) must be two arrays (n, k), whole numbers and reals")
    else:
        values = np.asarray(weights, dtype=float)
        if values.ndim != 2:
            raise _knead.InvalidInput(f"weights must be an array (vertices, bones), got {values.shape}")
        bones = np.broadcast_to(np.arange(values.shape[1]), values.shape)
    if len(values) != vertices:
        raise _knead.InvalidInput(f"weights has {len(values)} rows for {vertices} vertices")
    if bones.size and bones.min() < 0:
        raise _knead.InvalidInput("weights names a bone below 0")
    used = values != 0
    return np.concatenate([[0], np.cumsum(used.sum(axis=1))]), bones[used], values[used]


def _matrices(matrices, name):
    import numpy as np

    result = np.asarray(matrices, dtype=float)
    if result.ndim not in (3, 4) or result.shape[-2:] != (4, 4):
        raise _knead.InvalidInput(f"{name} must be matrices, (bones, 4, 4), got {result.shape}")
    return result


def skin(
    vertices,
    faces,
    weights,
    rest,
    poses,
    *,
    parents=None,
    rigid_weight=0.9,
    detail=0,
    measured=True,
    threads=0,
    progress=None,
):
    """Poses a shape by its skeleton, and returns a Posed; of several poses a list.

    Bones move rigidly, the flesh between them follows with the least strain. The volume stays, and what a pose brings
    together flattens and does not enter.

    vertices, faces: the shape at rest. faces: None where vertices is a mesh.
    weights: of each vertex for each bone, (n, bones); a sparse matrix of scipy; or a pair of (n, k): bones and weights.
    rest: where the bones are at rest, matrices (bones, 4, 4) that take a bone's coordinates to the shape's.
    poses: where they are in the pose, (bones, 4, 4); or several poses, (poses, bones, 4, 4).
    parents: the number of each bone's parent, -1 for none. Without them bones that share vertices hang together.
    rigid_weight: vertices whose weight of a bone is above this move rigidly.
    detail: spacing of the grids over the radius of the limbs, from 0.5 to 4; 0: the usual one.
    measured: False leaves linear blend and dual quaternions out of the report.
    progress: as for deform. If it returned False, skin returns None.

    Raises InvalidInput for input that does not fit together.
    """
    import numpy as np

    points = vertices.vertices if hasattr(vertices, "vertices") else vertices
    count = len(points)
    matrices = _matrices(poses, "poses")
    at_rest = _matrices(rest, "rest")
    begin, bones, values = _rows(weights, count)
    hung = _knead.Skin(begin, bones, values, np.asarray([] if parents is None else parents, dtype=np.int64), at_rest)
    shape = (points, faces_for(vertices, faces))
    results = []
    for pose in matrices if matrices.ndim == 4 else [matrices]:
        found = _knead.pose_skin(
            shape, hung, pose, _number(rigid_weight, "rigid_weight"), _number(detail, "detail"), bool(measured), operator.index(threads), progress
        )
        if found is None:
            return None
        strokes, posed, report = found
        session = Session()
        session._strokes = [_wrap(s) for s in strokes]
        results.append(
            Posed(
                posed,
                session,
                json.loads(report),
                _knead.linear_blend(points, hung, pose),
                _knead.dual_quaternion_blend(points, hung, pose),
                _knead.corrective_shape(points, posed, hung, pose),
            )
        )
    return results if matrices.ndim == 4 else results[0]
