# SPDX-License-Identifier: GPL-3.0-or-later
"""The closed meshes that knead.stamp presses in, as files that a session can name."""

import hashlib
import os
import shutil

import bmesh
import bpy
import numpy as np
from bpy.app.handlers import persistent

from . import shape, state
from .native import knead


_FOLDER = "knead_stamps"


def _temporary():
    """Returns the folder of the stamps' files before the first save. Blender removes it at its end."""
    return os.path.join(bpy.app.tempdir, _FOLDER)


def _folder():
    """Returns the folder of the stamps' files: beside the .blend file once there is one."""
    path = bpy.path.abspath(f"//{_FOLDER}") if bpy.data.filepath else _temporary()
    os.makedirs(path, exist_ok=True)
    return path


def settled(session, folder):
    """Returns the session with its temporary stamps copied to a folder beside a file in `folder`; None without any."""
    result, to = list(session), os.path.join(folder, _FOLDER)
    for i, stroke in enumerate(result):
        if stroke.tool == "stamp" and os.path.dirname(stroke.mesh) == _temporary():
            os.makedirs(to, exist_ok=True)
            result[i] = stroke.replace(mesh=shutil.copy(stroke.mesh, to))
    changed = any(a is not b for a, b in zip(result, session))
    return knead.Session(result, session.mesh, session.note) if changed else None


@persistent
def _settle(*_):
    """After the first save: the temporary stamps go beside the file, which is saved again with their names."""
    if not bpy.data.filepath:
        return
    changed = False
    for mesh in bpy.data.meshes:
        session = settled(state.parse(mesh.knead.session), os.path.dirname(bpy.data.filepath))
        if session is not None:
            mesh.knead.session, changed = session.text(), True
    if changed:
        bpy.ops.wm.save_mainfile()


def register():
    bpy.app.handlers.save_post.append(_settle)


def unregister():
    bpy.app.handlers.save_post.remove(_settle)


def _write(points, triangles):
    """Writes a PLY file named by its content; returns its path."""
    body = "".join(f"{x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in points.tolist())
    body += "".join(f"3 {a} {b} {c}\n" for a, b, c in triangles.tolist())
    head = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty float x\nproperty float y\nproperty float z\n"
    text = f"{head}element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n{body}"
    path = os.path.join(_folder(), hashlib.sha256(text.encode()).hexdigest()[:16] + ".ply")
    if not os.path.exists(path):
        with open(path + ".part", "w") as file:
            file.write(text)
        os.replace(path + ".part", path)
    return path


def _triangles(mesh):
    mesh.calc_loop_triangles()
    triangles = np.empty(3 * len(mesh.loop_triangles), np.int32)
    mesh.loop_triangles.foreach_get("vertices", triangles)
    return triangles.reshape(-1, 3)


def _ball():
    mesh = bpy.data.meshes.new("stamp")
    try:
        form = bmesh.new()
        bmesh.ops.create_icosphere(form, subdivisions=3, radius=1)
        form.to_mesh(mesh)
        form.free()
        return _arrays(mesh)
    finally:
        bpy.data.meshes.remove(mesh)


def _arrays(mesh):
    points = np.empty(3 * len(mesh.vertices), np.float32)
    mesh.vertices.foreach_get("co", points)
    return points.reshape(-1, 3).astype(np.float64), _triangles(mesh)


def make(settings, obj):
    """Returns the file of the stamp that is set, and its points. Raises Refusal for one that is not closed."""
    chosen = settings.stamp
    if chosen is not None and chosen.data == obj.data:
        raise state.Refusal("An object cannot be its own stamp; choose another")
    points, triangles = _ball() if chosen is None else _arrays(chosen.data)
    if len(triangles) == 0 or not knead.check(points, triangles)["closed"]:
        raise state.Refusal(f"The stamp {chosen.name} is not closed; choose a closed mesh")
    return _write(points, triangles), points
