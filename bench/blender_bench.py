"""Blender's grab and elastic grab brushes, its bend modifier, and Knead's pull and bend, on the same jobs in one run.

Run in Blender's window, for the brushes: KNEAD=build/release/knead bindings/blender/tests/window.sh out/knead_blender.zip
bench/blender_bench.py. Prints the table of docs/blender.md: time, error of the volume and crossings.
"""

import math
import os
import subprocess
import sys
import tempfile
import time

import bpy
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../bindings/blender/tests"))
from support import mesh_object
from window_support import coordinates, run

_POINTS = 20  # of a drag
_TOOLS = {
    "Blender's grab brush": "builtin_brush.Grab",
    "Blender's elastic grab brush": "builtin_brush.Elastic Deform",
    "Knead's pull": "knead.pull_tool",
    "Knead's pull, in object mode": "knead.pull_tool",
}


def fresh(kind, vertices):
    for each in list(bpy.data.objects):
        bpy.data.objects.remove(each)
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, f"{kind}.ply")
        subprocess.run([os.environ["KNEAD"], "make", kind, "-n", str(vertices), "-o", path], check=True, capture_output=True)
        obj = mesh_object(path)
    bpy.context.view_layer.update()
    return obj


def report(job, name, seconds, obj, before, after, goal):
    from knead_blender.native import knead

    faces = np.array([p.vertices[:] for p in obj.data.polygons])
    first, last = (knead.check(each.astype(float), faces) for each in (before, after))
    error = 100 * abs(last["volume"] / first["volume"] - 1)
    print(f"| {job} | {name} | {1000 * seconds:.0f} ms | {goal} | {error:.2g} % | {last['self_intersections']} |", flush=True)


def drag(window, obj, start, way):
    """Drags the tool of now from a place by a way, in events; returns the seconds with Blender's redraws."""
    a, b = (np.array(window.pixel(obj, place)) for place in (start, start + way))
    window.move(a)
    yield
    begin = time.perf_counter()
    yield from window.drag(a, b - a, steps=_POINTS)
    window.release()
    yield
    yield
    return time.perf_counter() - begin


def choose(window, name, radius, size):
    """Makes a tool active, with its radius in the mesh's units."""
    window.tool(_TOOLS[name])
    yield
    yield
    if name.startswith("Knead"):
        bpy.context.scene.knead.radius = radius / size
        return
    brush = bpy.context.tool_settings.sculpt.brush
    brush.strength = 1
    if "elastic" in name:
        brush.elastic_deform_type = "GRAB"
        brush.elastic_deform_volume_preservation = 0.9
    sizes = bpy.context.tool_settings.unified_paint_settings
    sizes.use_unified_size, sizes.use_locked_size, sizes.unprojected_radius = True, "SCENE", radius


def pull_jobs(window, job, length):
    for name in _TOOLS:
        obj = fresh("sphere", 40000)
        obj.data.use_mirror_x = False
        before = coordinates(obj)
        window.look(obj, "TOP", 0.7)
        with window.override():
            bpy.ops.object.mode_set(mode="OBJECT" if "object" in name else "SCULPT")
        yield
        yield from choose(window, name, 0.6, float(np.linalg.norm(np.ptp(before, axis=0))))
        start, way = np.array([0.0, np.sin(1.2), np.cos(1.2)]), np.array([0.0, length, 0.0])
        seconds = yield from drag(window, obj, start, way)
        with window.override():
            bpy.ops.object.mode_set(mode="OBJECT")
        yield
        after = coordinates(obj)
        reached = np.linalg.norm(after - before, axis=1).max()
        report(job, name, seconds, obj, before, after, f"{reached:.2f}")


def bend_jobs(job, degrees):
    from knead_blender.native import knead

    for name in ("Blender's bend modifier", "Knead's bend"):
        obj = fresh("hand", 40000)
        before = coordinates(obj)
        extent = np.ptp(before, axis=0)
        axis = int(extent.argmax())
        begin = time.perf_counter()
        if name.startswith("Knead"):
            middle = 0.5 * (before.min(axis=0) + before.max(axis=0))
            turn = np.eye(3)[(axis + 1) % 3]
            bend = knead.Bend(center=middle, axis=turn, normal=-np.eye(3)[axis], angle_deg=degrees, width=0.6 * extent[axis])
            after = knead.deform(before.astype(float), bend).astype(np.float32)
        else:
            modifier = obj.modifiers.new("bend", "SIMPLE_DEFORM")
            modifier.deform_method, modifier.deform_axis = "BEND", "XYZ"[(axis + 1) % 3]
            modifier.angle = math.radians(degrees)
            mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
            after = np.empty(3 * len(mesh.vertices), np.float32)
            mesh.vertices.foreach_get("co", after)
            after = after.reshape(-1, 3)
        seconds = time.perf_counter() - begin
        report(f"{job} by {degrees} degrees", name, seconds, obj, before, after, f"{np.abs(after - before).max():.2f}")


def test(window):
    print(f"Blender {bpy.app.version_string}")
    print("| job | by | time | greatest displacement | error of the volume | crossings |\n| --- | --- | --- | --- | --- | --- |")
    for length in (0.3, 0.8):
        yield from pull_jobs(window, f"a sphere of radius 1, pulled out by {length}", length)
    for degrees in (60, 120):
        bend_jobs("a hand bent", degrees)
        yield


run(test)
