"""SHAPE DUMP after "--": what Blender reads. Axes are undone: glTF's y up becomes Blender's z up on import."""
import sys

import bpy
import numpy as np

# Blender 3.4.1's glTF import says np.bool, which numpy 1.24 (both as in Debian 12) no longer has.
np.bool = bool


def load(path):
    kind = path.rsplit(".", 1)[1]
    if kind == "ply":
        bpy.ops.import_mesh.ply(filepath=path)
    elif kind == "stl":
        bpy.ops.import_mesh.stl(filepath=path)
    elif kind == "obj":
        bpy.ops.wm.obj_import(filepath=path, forward_axis="Y", up_axis="Z")
    else:
        bpy.ops.import_scene.gltf(filepath=path, merge_vertices=False)
    return kind == "glb"


def values(collection, name, width, kind=np.float64):
    # foreach_get wants Blender's own type: 32-bit numbers.
    out = np.zeros(len(collection) * width, np.float32 if kind is np.float64 else np.int32)
    collection.foreach_get(name, out)
    return out.astype(kind).reshape(-1, width)


def colors(mesh, corners):
    if not mesh.color_attributes:
        return np.zeros((0, 4))
    layer = mesh.color_attributes[0]
    # "color" is linear; of a byte layer "color_srgb" is what the file held.
    rows = values(layer.data, "color_srgb" if layer.data_type == "BYTE_COLOR" else "color", 4)
    return rows[corners] if layer.domain == "POINT" and len(corners) else rows


def parts_of(object_, y_up):
    mesh = object_.data
    matrix = np.array(object_.matrix_world, float)
    positions = values(mesh.vertices, "co", 3) @ matrix[:3, :3].T + matrix[:3, 3]
    mesh.calc_normals_split()
    normals = values(mesh.loops, "normal", 3) @ np.linalg.inv(matrix[:3, :3])
    if not mesh.has_custom_normals:
        normals = np.zeros((0, 3))
    if y_up:
        positions = np.stack([positions[:, 0], positions[:, 2], -positions[:, 1]], 1)
        normals = np.stack([normals[:, 0], normals[:, 2], -normals[:, 1]], 1)
    sizes = values(mesh.polygons, "loop_total", 1, np.int32)[:, 0]
    corners = values(mesh.loops, "vertex_index", 1, np.int32)[:, 0]
    uv = values(mesh.uv_layers[0].data, "uv", 2) if mesh.uv_layers and len(corners) else np.zeros((0, 2))
    return positions, sizes, corners, uv, colors(mesh, corners), normals


def together(parts):
    first = np.cumsum([0] + [len(p[0]) for p in parts])
    columns = [np.concatenate([p[i] + (at if i == 2 else 0) for p, at in zip(parts, first)]) for i in range(3)]
    for i, width in ((3, 2), (4, 4), (5, 3)):
        rows = [p[i] if len(p[i]) else np.zeros((len(p[2]) or len(p[0]), width)) for p in parts]
        columns.append(np.concatenate(rows) if any(len(p[i]) for p in parts) else np.zeros((0, width)))
    return columns


def main(shape, dump):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    y_up = load(shape)
    bpy.context.view_layer.update()
    columns = together([parts_of(o, y_up) for o in bpy.context.scene.objects if o.type == "MESH"])
    with open(dump, "wb") as file:
        file.write(np.array([len(c) for c in columns], "u8").tobytes())
        for column, kind in zip(columns, ("f8", "i4", "i4", "f8", "f8", "f8")):
            file.write(column.astype(kind).tobytes())


main(*sys.argv[sys.argv.index("--") + 1:])
