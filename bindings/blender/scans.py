"""Run in Blender's window by scans.sh: three scans are changed by the tools, with events; pictures before and after.

Prints for each what the panel says, and the time of a step of the drag besides Blender's redraw. The folder of the meshes is the last argument.
"""

import os
import sys
import time

import bpy
import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(__file__), "tests"))
from support import mesh_object
from window_support import PICTURES, run

MESHES = sys.argv[-1]
# Mesh, how close to look, and strokes: tool, where to press and by how much to drag in pixels of a 3D view of 1057 x 759,
# the settings that differ. Seen from above, as these meshes stand along y.
SCANS = {
    "smile": (
        "bust_nefertiti_35k.ply",
        2.2,
        True,
        [("pull", (477, 296), (-16, 12), {"radius": 0.04})],
    ),
    "ear": ("armadillo_173k_constructed.ply", 1.1, False, [("pull", (455, 650), (-12, 30), {"radius": 0.07})]),
    "arm": ("armadillo_173k_constructed.ply", 1.1, False, [("bend", (345, 535), (0, -140), {"widen_zone": False})]),
}


def timed(steps):
    """Adds the milliseconds of each step of a drag, without Blender's redraw, to the list."""
    from knead_blender import tools

    update = tools.Tool._update

    def measured(self, context, pointer):
        start, work = time.perf_counter(), time.process_time()
        update(self, context, pointer)
        steps.append((1000 * (time.perf_counter() - start), 1000 * (time.process_time() - work)))

    tools.Tool._update = measured


def open_tab(window):
    """Opens the sidebar with the tab Knead."""
    window.area.spaces.active.show_region_ui = True
    for _ in range(3):
        yield
    window.move((window.region.width - 12, window.region.height - 180))
    yield
    window.key("LEFTMOUSE")
    yield


def scan(window, name, steps):
    file, closer, mirror, strokes = SCANS[name]
    for each in list(bpy.data.objects):
        bpy.data.objects.remove(each)
    obj = mesh_object(os.path.join(MESHES, file))
    obj.data.use_mirror_x = mirror
    window.look(obj, "TOP", closer)
    with window.override():
        bpy.ops.knead.check()
    for _ in range(4):
        yield
    window.picture(os.path.join(PICTURES, f"{name}_before.png"))
    yield
    for tool, pixel, by, changed in strokes:
        for key, value in changed.items():
            setattr(bpy.context.scene.knead, key, value)
        window.tool(f"knead.{tool}_tool")
        yield from window.drag(pixel, by, steps=20)
        window.release()
        for _ in range(4):
            yield
    with window.override():
        bpy.ops.knead.check()
    window.move((60, 60))
    for _ in range(4):
        yield
    window.picture(os.path.join(PICTURES, f"{name}_after.png"))
    yield
    wall, work = np.array(steps[1:]).T
    print(f"{name}: {len(obj.data.vertices)} vertices, {len(obj.data.knead.strokes)} strokes; a step takes "
          f"{np.median(wall):.1f} ms (median), {wall.max():.1f} ms at most of {len(wall)}; {np.median(work):.1f} ms of "
          f"all processors together (median), on a machine with a load of {os.getloadavg()[0]:.1f}")
    print("    " + "\n    ".join(bpy.context.object.knead.report.splitlines()))


def test(window):
    yield from open_tab(window)
    for name in SCANS:
        steps = []
        timed(steps)
        yield from scan(window, name, steps)
        bpy.context.scene.knead.property_unset("radius")


run(test)
