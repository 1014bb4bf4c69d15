"""Time and memory of a drag on a large mesh, inside Blender without its redraw.

Run by: bindings/blender/tests/run.sh out/knead_blender.zip bench/blender_large.py. KNEAD_VERTICES: how many (2 million).
"""

import os
import resource
import subprocess
import sys
import tempfile
import time

import bpy
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../bindings/blender/tests"))
from support import mesh_object

_VERTICES = os.environ.get("KNEAD_VERTICES", "2000000")


def memory():
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def timed(what, work):
    start, used = time.perf_counter(), time.process_time()
    result = work()
    print(f"{what}: {1000 * (time.perf_counter() - start):.0f} ms ({1000 * (time.process_time() - used):.0f} ms of processors),"
          f" {memory():.0f} MB at most so far", flush=True)
    return result


def main():
    from knead_blender import live, shape
    from knead_blender.native import knead

    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="knead_blender")
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "sphere.ply")
        subprocess.run([os.environ["KNEAD"], "make", "sphere", "-n", _VERTICES, "-o", path], check=True, capture_output=True)
        obj = timed("Blender's mesh", lambda: mesh_object(path))
    print(len(obj.data.vertices), "vertices")
    kept = timed("the press: the mesh enters the library", lambda: live.begin(obj))
    timed("the press: what the pointer touches", lambda: kept.surface)
    before, steps, used = shape.read(obj), [], []
    path = [[0.0, 0.0, 0.95]]
    for i in range(20):
        path.append([0.005 * (i + 1), 0.0, 0.95 + 0.005 * (i + 1)])
        strokes = [knead.Implicit(path=path, inner=0.1, outer=0.3)]
        start, work = time.perf_counter(), time.process_time()
        kept.set_strokes(strokes)
        live.show(obj, kept)
        steps.append(1000 * (time.perf_counter() - start))
        used.append(1000 * (time.process_time() - work))
    coordinates, writes = kept.coordinates.ravel(), []
    for _ in range(10):
        start = time.perf_counter()
        obj.data.vertices.foreach_set("co", coordinates)
        writes.append(1000 * (time.perf_counter() - start))
    print(f"writing all coordinates to Blender's mesh: {np.median(writes):.2f} ms (median)")
    print(f"a step of a drag: {np.median(steps):.0f} ms (median), {max(steps):.0f} ms at most;"
          f" {np.median(used):.0f} ms of processors (median)")
    timed("the release: the session is kept", lambda: live.keep(None, obj, kept, strokes, before))
    timed("the next press", lambda: live.begin(obj).surface)
    print(f"load of the machine: {os.getloadavg()[0]:.1f}")


main()
