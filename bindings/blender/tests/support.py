"""What the tests inside Blender share."""

import json
import os
import subprocess
import sys
import tempfile
import unittest

import bpy
import numpy as np

ADDON = os.environ.get("KNEAD_ADDON", "knead_blender")  # the name of its module, which is another one as an extension
_scratch = tempfile.TemporaryDirectory()


def enable():
    """Enables the add-on, and lets tests import it as `knead_blender`."""
    bpy.ops.preferences.addon_enable(module=ADDON)
    for name in [each for each in sys.modules if each == ADDON or each.startswith(ADDON + ".")]:
        sys.modules["knead_blender" + name[len(ADDON) :]] = sys.modules[name]


def read_ply(path):
    """Returns the float32 vertices of a binary PLY file with x, y, z as floats first."""
    from knead_blender.native import knead

    return knead.read(path).vertices.astype(np.float32)


def deform(vertices, faces, session, folder):
    """Returns what the command makes of float32 vertices, as float32."""
    source, result = os.path.join(folder, "in.ply"), os.path.join(folder, "out.ply")
    with open(source, "wb") as file:
        file.write(
            f"ply\nformat binary_little_endian 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\n"
            f"property float z\nelement face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n".encode()
        )
        file.write(np.asarray(vertices, "<f4").tobytes())
        rows = np.empty(len(faces), np.dtype([("n", "u1"), ("v", "<i4", 3)]))
        rows["n"], rows["v"] = 3, faces
        file.write(rows.tobytes())
    subprocess.run([os.environ["KNEAD"], "deform", source, session, "--keep-mesh", "-o", result], check=True, capture_output=True)
    return read_ply(result)


def make_hand(vertices=5000):
    """Adds a procedural hand to an empty scene's collection, and makes it active."""
    from knead_blender.native import knead

    path = os.path.join(_scratch.name, f"hand{vertices}.ply")
    if not os.path.exists(path):
        subprocess.run([os.environ["KNEAD"], "make", "hand", "-n", str(vertices), "-o", path], check=True, capture_output=True)
    shape = knead.read(path)
    mesh = bpy.data.meshes.new("hand")
    mesh.from_pydata(shape.vertices.tolist(), [], shape.faces.tolist())
    obj = bpy.data.objects.new("hand", mesh)
    bpy.context.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    return obj


def mesh_object(path):
    """Adds the triangles of a file as an object, and makes it active."""
    from knead_blender.native import knead

    shape = knead.read(path)
    faces = shape.triangles
    mesh = bpy.data.meshes.new(os.path.basename(path))
    mesh.vertices.add(len(shape.vertices))
    mesh.vertices.foreach_set("co", shape.vertices.astype(np.float32).ravel())
    mesh.loops.add(faces.size)
    mesh.loops.foreach_set("vertex_index", faces.astype(np.int32).ravel())
    mesh.polygons.add(len(faces))
    mesh.polygons.foreach_set("loop_start", np.arange(0, faces.size, 3, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(len(faces), 3, np.int32))
    mesh.polygons.foreach_set("use_smooth", np.ones(len(faces), bool))
    mesh.update(calc_edges=True)
    obj = bpy.data.objects.new(mesh.name, mesh)
    bpy.context.collection.objects.link(obj)
    bpy.context.view_layer.objects.active = obj
    return obj


def session_file(folder, tip=None):
    """Returns a session of a pull and a turn at the tip of the longest finger, or at another place."""
    obj = bpy.context.object
    if tip is None:
        tip = max((v.co[:] for v in obj.data.vertices), key=lambda co: co[1])
        if os.path.exists(os.path.join(folder, "strokes.knead")):
            return os.path.join(folder, "strokes.knead")
    tip = [float(x) for x in tip]
    path = os.path.join(folder, "strokes.knead")
    pull = {"tool": "implicit", "inner": 0.05, "outer": 0.3, "path": [tip, [tip[0], tip[1] + 0.15, tip[2] + 0.05]]}
    turn = {"tool": "rotate", "center": tip, "axis": [1, 0, 0], "angle_deg": 30, "inner": 0.1, "outer": 0.4}
    with open(path, "w") as file:
        file.write("\n".join(json.dumps(line) for line in ({"knead": 1}, pull, turn)) + "\n")
    return path


def key_values(obj, index):
    key = obj.data.shape_keys.key_blocks[index]
    flat = np.empty(3 * len(key.data), np.float32)
    key.data.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def refuses(case, work, text):
    """Asserts that an operator ends with an error that holds the text."""
    with case.assertRaises(RuntimeError) as caught:
        work()
    case.assertIn(text, str(caught.exception))


class Case(unittest.TestCase):
    def setUp(self):
        bpy.ops.wm.read_factory_settings(use_empty=True)
        enable()
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = scratch.name

    def same(self, a, b):
        np.testing.assert_array_equal(np.asarray(a).view(np.uint32), np.asarray(b).view(np.uint32))

    def vertices(self, obj):
        flat = np.empty(3 * len(obj.data.vertices), np.float32)
        obj.data.vertices.foreach_get("co", flat)
        return flat.reshape(-1, 3)

    def base(self, obj):
        flat = np.empty(3 * len(obj.data.vertices), np.float32)
        obj.data.attributes["knead_base"].data.foreach_get("vector", flat)
        return flat.reshape(-1, 3)

    def faces(self, obj):
        return np.array([p.vertices[:] for p in obj.data.polygons], np.int32)

    def evaluated(self, obj, frame):
        bpy.context.scene.frame_set(frame)
        mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        flat = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", flat)
        return flat.reshape(-1, 3)


def run(*cases):
    loader = unittest.defaultTestLoader
    suite = unittest.TestSuite(loader.loadTestsFromTestCase(case) for case in cases)
    if not unittest.TextTestRunner(stream=sys.stdout).run(suite).wasSuccessful():
        raise SystemExit(1)
