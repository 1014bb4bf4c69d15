"""Vertices and faces as callers have them."""

import os

from ._knead import InvalidInput


def faces_for(vertices, faces=None):
    """Returns the faces that go with the vertices, in a form that the library takes: those given, or those of a mesh.

    A mesh is of trimesh, pyvista, open3d or meshio, or has .faces; None for arrays, points and volumes. Faces may be a
    flat list [n, v1 ... vn, n, ...], and reals that are whole numbers.
    """
    import numpy as np

    if isinstance(vertices, (str, bytes, os.PathLike)):
        raise TypeError(f"{vertices!r} is the path of a shape; read it by knead.read")
    if type(vertices).__name__ == "Scene" and hasattr(vertices, "geometry"):
        raise TypeError("a trimesh.Scene holds several meshes; give one of scene.geometry, or scene.to_mesh() for all")
    if faces is None:
        if isinstance(vertices, (np.ndarray, list, tuple)):
            return None
        return _faces_of(vertices)
    return whole(faces)


def whole(faces):
    """Returns faces as whole numbers, and a flat list as faces."""
    import numpy as np

    if isinstance(faces, (list, tuple)) and any(np.ndim(face) == 1 and len(face) != len(faces[0]) for face in faces):
        return [_integers(face) if isinstance(face, np.ndarray) else face for face in faces]
    if isinstance(faces, (list, tuple)) and any(isinstance(v, (float, np.floating)) for face in faces[:1] for v in np.ravel(face)):
        faces = np.asarray(faces)
    if not isinstance(faces, np.ndarray):
        return faces
    faces = _integers(faces)
    if faces.ndim == 1 and len(faces) and faces.dtype.kind in "iu":
        return polygons(faces)
    return faces


def _integers(faces):
    import numpy as np

    if np.ma.is_masked(faces):
        raise InvalidInput("faces is a masked array with masked values; fill or remove them")
    if faces.dtype.kind != "f":
        return faces
    numbers = np.asarray(faces)
    if not np.isfinite(numbers).all() or (numbers != np.floor(numbers)).any():
        raise TypeError("faces must hold whole numbers, got reals that are none")
    return numbers.astype(np.int64)


def _faces_of(mesh):
    import numpy as np

    package = type(mesh).__module__.split(".")[0]
    if package == "open3d":
        return np.asarray(mesh.triangles) if hasattr(mesh, "triangles") else None
    if hasattr(mesh, "faces"):
        faces = mesh.faces
        flat = np.ndim(faces) == 1 and len(faces) and np.isscalar(faces[0])
        return polygons(np.asarray(faces)) if flat else whole(faces)
    cells = getattr(mesh, "cells", None)
    if not isinstance(cells, (list, tuple)):
        return None
    corners = {"triangle": 3, "quad": 4, "polygon": None}  # the corners of "triangle6" come before its other nodes
    kinds = [(block, block.type.rstrip("0123456789")) for block in cells if isinstance(getattr(block, "type", None), str)]
    return [face[: corners[kind]] for block, kind in kinds if kind in corners for face in block.data] or None


def polygons(flat):
    """Returns the faces of a list [n, v1 ... vn, n, ...]."""
    if flat.dtype.kind not in "iu":
        raise TypeError(f"faces must be an array of whole numbers, got dtype {flat.dtype}")
    step = int(flat[0]) + 1
    if step > 1 and len(flat) % step == 0 and (flat[::step] == flat[0]).all():
        return flat.reshape(-1, step)[:, 1:]
    faces, at = [], 0
    while at < len(flat):
        if not 1 <= flat[at] < len(flat) - at:
            raise InvalidInput(f"faces must be a list [n, v1 ... vn, n, ...]; at {at} it counts {flat[at]} corners")
        end = at + 1 + int(flat[at])
        faces.append(flat[at + 1 : end])
        at = end
    return faces
