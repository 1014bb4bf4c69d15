"""Meshes of other packages, none of which is needed here."""

import copy

from ._deform import deform


def deform_mesh(mesh, session, **options):
    """Returns a mesh of the same kind with its vertices deformed; the given one stays as it is.

    mesh: of trimesh, meshio, open3d or pyvista, or anything with .vertices and .faces, .points and .cells, or .points and
    .faces. options: those of deform, but `faces` and `out`. Normals that the object has computed are computed anew where
    its package does so.
    """
    import numpy as np

    name = next((n for n in ("vertices", "points") if hasattr(mesh, n)), None)
    if name is None:
        raise TypeError(f"deform_mesh needs an object with .vertices or .points, got a {type(mesh).__name__}")
    given = np.asarray(getattr(mesh, name))
    moved = deform(given, session, _faces_of(mesh), **options)
    if moved is None:
        return None
    if type(mesh).__module__.split(".")[0] == "open3d":
        return _open3d(mesh, name, moved)
    result = mesh.copy() if hasattr(mesh, "copy") else copy.deepcopy(mesh)
    setattr(result, name, moved.astype(given.dtype, copy=False) if given.dtype.kind == "f" else moved)
    return result


def _faces_of(mesh):
    """Returns the polygons of a mesh, or None for points and volumes."""
    import numpy as np

    if hasattr(mesh, "triangles"):
        return np.asarray(mesh.triangles)
    if hasattr(mesh, "regular_faces") and hasattr(mesh, "irregular_faces"):  # pyvista
        return [f for f in mesh.irregular_faces] if mesh.n_cells else None
    if hasattr(mesh, "faces"):
        faces = mesh.faces
        return _polygons(np.asarray(faces)) if np.ndim(faces) == 1 and len(faces) and np.isscalar(faces[0]) else faces
    cells = getattr(mesh, "cells", None)
    if not isinstance(cells, (list, tuple)):
        return None
    kinds = ("triangle", "quad", "polygon")
    surface = [face for block in cells if block.type.startswith(kinds) for face in block.data]
    return surface or None


def _polygons(flat):
    """Returns the faces of a list [n, v1 ... vn, n, ...]."""
    faces, at = [], 0
    while at < len(flat):
        end = at + 1 + int(flat[at])
        faces.append(flat[at + 1 : end])
        at = end
    return faces


def _open3d(mesh, name, moved):
    import numpy as np
    import open3d

    result = copy.copy(mesh)
    setattr(result, name, open3d.utility.Vector3dVector(np.asarray(moved, dtype=np.float64)))
    if hasattr(result, "has_triangle_normals") and result.has_triangle_normals():
        result.compute_triangle_normals()
    if hasattr(result, "has_vertex_normals") and result.has_vertex_normals():
        result.compute_vertex_normals()
    return result
