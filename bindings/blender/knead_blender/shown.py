# SPDX-License-Identifier: GPL-3.0-or-later
"""A mesh as the 3D view shows it: by shape keys, an armature and other modifiers that move its vertices."""

from contextlib import contextmanager

import bpy
import numpy as np

from . import shape

_NEW_VERTICES = {  # modifiers that change which vertices there are, or may
    "ARRAY", "BEVEL", "BOOLEAN", "BUILD", "DECIMATE", "EDGE_SPLIT", "EXPLODE", "FLUID", "MASK", "MESH_TO_VOLUME", "MIRROR",
    "MULTIRES", "NODES", "OCEAN", "PARTICLE_INSTANCE", "REMESH", "SCREW", "SKIN", "SOLIDIFY", "SUBSURF", "TRIANGULATE",
    "VOLUME_TO_MESH", "WELD", "WIREFRAME",
}  # fmt: skip
_FROM_A_FILE = {"MESH_CACHE", "MESH_SEQUENCE_CACHE"}
_ROUNDING = 1e-6  # of the greatest coordinate
_TOLERANCE = 1e-5  # of the diagonal: the distance of a place that is followed back
_PROBE = 2.0**-8  # of the diagonal
_FLATTEST = 0.02  # the least singular value of a vertex's motion, where 1 is a rigid one
_MOST_STEPS = 8


def require_seen(obj):
    """Raises Refusal where a change of the mesh would not be seen."""
    for modifier in obj.modifiers:
        if modifier.show_viewport and modifier.type in _FROM_A_FILE:
            raise shape.Refusal(f"The modifier {modifier.name} shows positions of a file, so a stroke would not be seen; hide it first")


def read(obj):
    """Returns the coordinates that the 3D view shows, (n, 3) float32: exactly those of shape.read() where nothing moves
    them. Modifiers that add vertices are left out. Raises Refusal where the vertices shown are not those of the mesh."""
    edited = shape.read(obj)
    may_move = any(m.show_viewport and (m.type == "NODES" or m.type not in _NEW_VERTICES) for m in obj.modifiers)
    if not may_move and obj.data.shape_keys is None:
        return edited
    found = _evaluated(obj)
    return edited if _is_near(found, edited) else found


def is_posed(obj):
    """Returns whether what is shown differs from what is edited."""
    return not np.array_equal(read(obj), shape.read(obj))


def follow(obj, wanted):
    """Returns the coordinates that edits must give the mesh, so that the `wanted` ones are shown. Changes nothing.

    Raises Refusal where there are none."""
    return Link(obj).follow(wanted) if is_posed(obj) else wanted


def _is_near(a, b):
    return len(a) == 0 or np.abs(a - b).max() <= _ROUNDING * np.abs(b).max()


@contextmanager
def _own_vertices(obj):
    hidden = [m for m in obj.modifiers if m.show_viewport and m.type in _NEW_VERTICES]
    try:
        for modifier in hidden:
            modifier.show_viewport = False
        yield
    finally:
        for modifier in hidden:
            modifier.show_viewport = True


def _coordinates(obj):
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    flat = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def _evaluated(obj):
    found = _coordinates(obj)
    if len(found) == len(obj.data.vertices):
        return found
    with _own_vertices(obj):
        found = _coordinates(obj)
    if len(found) != len(obj.data.vertices):
        raise shape.Refusal("A modifier changes which vertices the mesh has; hide it in the viewport, or apply it")
    return found


class Link:
    """How the vertices shown follow those that are edited: near a pose each by a matrix of its own.

    The matrices are measured: the mesh is moved a little along x, y and z, and put back."""

    def __init__(self, obj):
        self._obj, self.edited, self.shown = obj, shape.read(obj), _evaluated(obj)
        self._size = float(np.linalg.norm(np.ptp(self.shown.astype(np.float64), axis=0))) or 1.0
        matrices = self._measured(_PROBE * self._size)
        values = np.linalg.svd(matrices, compute_uv=False)
        self._is_free = values[:, 2] >= _FLATTEST
        matrices[~self._is_free] = np.eye(3)
        self._back = np.linalg.inv(matrices)
        self._back[~self._is_free] = 0
        if not self._is_free.any():
            raise shape.Refusal(_why_unseen(obj))

    def _measured(self, step):
        matrices = np.empty((len(self.edited), 3, 3))
        try:
            for axis in range(3):
                probe = self.edited.copy()
                probe[:, axis] += np.float32(step)
                way = (probe - self.edited)[:, axis].astype(np.float64)
                matrices[:, :, axis] = (self._seen(probe).astype(np.float64) - self.shown) / way[:, None]
        finally:
            shape.write(self._obj, self.edited)
        return matrices

    def _seen(self, edited):
        shape.write(self._obj, edited)
        return _evaluated(self._obj)

    def nearly(self, wanted):
        """Returns the coordinates to edit, as one step of matrices gives them: for a drag."""
        return self._step(self.edited, wanted.astype(np.float64) - self.shown)

    def _step(self, edited, way):
        moved = edited + np.einsum("nij,nj->ni", self._back, way)
        return np.where((way == 0).all(axis=1)[:, None], edited, moved).astype(np.float32)

    def follow(self, wanted):
        """Returns the coordinates to edit for those that shall be shown. Raises Refusal where there are none."""
        moves = (wanted != self.shown).any(axis=1)
        best, least, edited = None, np.inf, self.edited
        try:
            for _ in range(_MOST_STEPS):
                way = np.where(moves[:, None], wanted.astype(np.float64) - self._seen(edited), 0)
                error = float(np.linalg.norm(way, axis=1).max(initial=0))
                if not error < 0.5 * least:
                    break
                best, least = edited, error
                edited = self._step(edited, way)
        finally:
            shape.write(self._obj, self.edited)
        if least > _TOLERANCE * self._size:
            if (moves & ~self._is_free).any():
                raise shape.Refusal(_why_unseen(self._obj))
            raise shape.Refusal("The stroke cannot be followed back through the modifiers; apply them, or hide them in the viewport")
        return best


def _why_unseen(obj):
    key = obj.active_shape_key
    if key is not None and (key.mute or key.value == 0) and key != obj.data.shape_keys.reference_key:
        return f"The shape key {key.name} is not shown; raise its value, or choose another one"
    what = "the mesh" if key is None else f"the shape key {key.name}"
    return f"Changes of {what} are not shown, because other shape keys or modifiers replace them; choose another shape key, or hide them"
