"""FILES after "--", a JSON file that lists paths: Blender reads each, and prints a line PLACES {path: [place, ...]} with
the places of their vertices, each once. Run by wild_files.py within Blender."""
import contextlib
import json
import os
import sys

import bpy
import numpy as np

np.bool = bool  # Blender 3.4.1's glTF import says np.bool, which numpy 1.24 no longer has

IMPORTS = {
    "ply": lambda path: bpy.ops.import_mesh.ply(filepath=path),
    "stl": lambda path: bpy.ops.import_mesh.stl(filepath=path),
    "obj": lambda path: bpy.ops.wm.obj_import(filepath=path, forward_axis="Y", up_axis="Z"),
    "gltf": lambda path: bpy.ops.import_scene.gltf(filepath=path),
    "glb": lambda path: bpy.ops.import_scene.gltf(filepath=path),
}


def places_of(path):
    bpy.ops.wm.read_factory_settings(use_empty=True)
    kind = path.rsplit(".", 1)[1]
    IMPORTS[kind](path)
    bpy.context.view_layer.update()
    meshes = [o for o in bpy.context.scene.objects if o.type == "MESH"]
    points = [tuple(o.matrix_world @ v.co) for o in meshes for v in o.data.vertices]
    if kind in ("gltf", "glb"):
        points = [(x, z, -y) for x, y, z in points]
    return sorted({tuple(round(x, 4) + 0.0 for x in p) for p in points})


def main(files):
    with open(files, encoding="utf-8") as file:
        paths = json.load(file)
    places = {}
    with open(os.devnull, "w", encoding="utf-8") as nothing:
        for path in paths:
            with contextlib.suppress(Exception), contextlib.redirect_stdout(nothing):
                places[path] = places_of(path)
    print("PLACES " + json.dumps(places), flush=True)


main(sys.argv[sys.argv.index("--") + 1])
