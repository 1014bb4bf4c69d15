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
    this pose ("flow"). problem: why the pose is spoiled, in a sentence; empty if nothing crosses that did not at rest, and no
    triangle is stretched or pressed by more than 5. linear, dual: the vertices of these two. corrective: the rest shape that linear blend takes to
    `vertices`; without the rest vertices it is a morph target.
    """

    def __init__(self, vertices, session, report, linear, dual, corrective):
        self.vertices = vertices
        self.session = session
        self.report = report
        self.problem = report["problem"]
        self.linear = linear
        self.dual = dual
        self.corrective = corrective

    def __repr__(self):
        flow = self.report["flow"]
        volume = "no volume" if flow["volume_error"] is None else f"volume {100 * flow['volume_error']:+.2g}%"
        return f"<knead.Posed: {len(self.session)} strokes, {volume}, {flow['crossings_new']} new crossings>"


class Corrective:
    """A corrective shape and the joints that drive it.

    bones: the bone behind each joint; two: a combination of neighbours. axes: what each turns about, in the shape's
    coordinates at rest. angles_deg: how far each turns at weight 1. offsets: what is added to each vertex at rest. The
    weight at other angles: the square of the part of the angle, from 0 to 1; of two joints the product.
    problem: why the pose from which it was made is spoiled, as Posed.problem.
    """

    def __init__(self, bones, axes, angles_deg, offsets, problem):
        self.bones = bones
        self.axes = axes
        self.angles_deg = angles_deg
        self.offsets = offsets
        self.problem = problem

    def __repr__(self):
        return f"<knead.Corrective: bones {list(map(int, self.bones))}, {[round(float(a), 1) for a in self.angles_deg]} degrees>"


def _reals(values, name):
    import numpy as np

    try:
        return np.asarray(values, dtype=float)
    except OverflowError:
        raise _knead.InvalidInput(f"{name} holds a number that is too large") from None


def _rows(weights, vertices):
    """Returns begin, bones and weights of sparse rows: of a dense array, a scipy matrix, or (bones, weights)."""
    import numpy as np

    if hasattr(weights, "tocsr"):
        rows = weights.tocsr()
        if rows.shape[0] != vertices:
            raise _knead.InvalidInput(f"weights has {rows.shape[0]} rows for {vertices} vertices")
        return np.asarray(rows.indptr), np.asarray(rows.indices), np.asarray(rows.data, dtype=float)
    if isinstance(weights, tuple) and len(weights) == 2:
        bones, values = np.asarray(weights[0]), _reals(weights[1], "weights")
        if bones.ndim != 2 or bones.shape != values.shape or bones.dtype.kind not in "iu":
            raise _knead.InvalidInput("weights as (bones, weights) must be two arrays (n, k), whole numbers and reals")
    else:
        values = _reals(weights, "weights")
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
    result = _reals(matrices, name)
    if result.ndim not in (3, 4) or result.shape[-2:] != (4, 4):
        raise _knead.InvalidInput(f"{name} must be matrices, (bones, 4, 4), got {result.shape}")
    return result


def _hung(vertices, faces, weights, rest, parents):
    """Returns the points, what the library takes for the shape, and the skin."""
    import numpy as np

    points = vertices.vertices if hasattr(vertices, "vertices") else vertices
    begin, bones, values = _rows(weights, len(points))
    chain = np.asarray([] if parents is None else parents)
    if chain.ndim != 1 or (chain.size and chain.dtype.kind not in "iu"):
        raise TypeError(f"parents must be a list of whole numbers, got {chain.dtype} {chain.shape}")
    try:
        skin_of = _knead.Skin(begin, bones, values, chain.astype(np.int64), _matrices(rest, "rest"))
    except OverflowError:
        raise _knead.InvalidInput("weights or parents name a bone that is too large a number") from None
    return points, (points, faces_for(vertices, faces)), skin_of


def correctives(
    vertices, faces, weights, rest, pose, *, parents=None, rigid_weight=0.9, detail=0, threads=0, progress=None
):
    """Makes corrective shapes for a pose, and returns a list of Corrective.

    There is one for each joint that turns by 5 degrees or more, made with all others at rest, and one for each such joint
    and the nearest turning joint before it. Added to the rest shape by their joints' angles, they make linear blend
    skinning give the flow's shape. Arguments as for skin.
    """
    _, shape, hung = _hung(vertices, faces, weights, rest, parents)
    made = _knead.correctives(
        shape, hung, _matrices(pose, "pose"), _number(rigid_weight, "rigid_weight"), _number(detail, "detail"), operator.index(threads), progress
    )
    return None if made is None else [Corrective(*one) for one in made]


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
    matrices = _matrices(poses, "poses")
    points, shape, hung = _hung(vertices, faces, weights, rest, parents)
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
