"""Run by compare.py inside Blender: plays o.pc2, o.mdd and o.glb of a folder, and saves the vertices of each frame."""

import pathlib
import sys

import bpy
import numpy as np

folder, frames = pathlib.Path(sys.argv[-2]), int(sys.argv[-1])
np.bool = bool  # the glTF importer of Blender 3.4 is older than numpy 1.24


def shown(thing):
    """The vertices of an object in every frame, with modifiers and shape keys."""
    result = []
    for k in range(frames):
        bpy.context.scene.frame_set(k)
        evaluated = thing.evaluated_get(bpy.context.evaluated_depsgraph_get())
        mesh = evaluated.to_mesh()
        places = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", places)
        result.append(places.reshape(-1, 3))
        evaluated.to_mesh_clear()
    return np.array(result)


for kind in ("PC2", "MDD"):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    path = folder / f"o.{kind.lower()}"
    count = int.from_bytes(path.read_bytes()[16:20], "little") if kind == "PC2" else int.from_bytes(path.read_bytes()[4:8], "big")
    mesh = bpy.data.meshes.new("shape")
    mesh.vertices.add(count)
    thing = bpy.data.objects.new("shape", mesh)
    bpy.context.scene.collection.objects.link(thing)
    cache = thing.modifiers.new("cache", "MESH_CACHE")
    cache.cache_format, cache.filepath, cache.frame_start = kind, str(path), 0
    cache.interpolation, cache.forward_axis, cache.up_axis = "NONE", "POS_Y", "POS_Z"
    np.save(folder / f"blender_{kind}.npy", shown(thing))

bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.context.scene.render.fps = 24
bpy.ops.import_scene.gltf(filepath=str(folder / "o.glb"))
places = shown(next(thing for thing in bpy.context.scene.objects if thing.type == "MESH"))
np.save(folder / "blender_glTF.npy", np.stack([places[..., 0], places[..., 2], -places[..., 1]], axis=-1))  # z is up there
