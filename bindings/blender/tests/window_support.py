"""Drives Blender's window by simulated events: a test is a generator that yields wherever the window may catch up."""

import os
import sys
import traceback

import bpy
import numpy as np
from bpy_extras import view3d_utils

from support import make_hand

PICTURES = next(iter(sys.argv[sys.argv.index("--") + 1 :]), None)  # a folder for pictures, or none
_STEP = 0.02  # seconds between two steps of a test


class Window:
    """The 3D view of the window, its pointer and keys."""

    def __init__(self):
        self.window = bpy.context.window_manager.windows[0]
        self.area = max((a for a in self.window.screen.areas if a.type == "VIEW_3D"), key=lambda a: a.width * a.height)
        self.region = next(r for r in self.area.regions if r.type == "WINDOW")
        self.data = self.area.spaces.active.region_3d
        self.at = (0, 0)
        if not PICTURES:
            self.area.spaces.active.overlay.show_overlays = False  # half of the time of a redraw in software

    def override(self):
        return bpy.context.temp_override(window=self.window, area=self.area, region=self.region)

    def event(self, kind, value="PRESS", **held):
        self.window.event_simulate(type=kind, value=value, x=self.at[0], y=self.at[1], **held)

    def move(self, pixel, **held):
        self.at = int(pixel[0] + self.region.x), int(pixel[1] + self.region.y)
        self.event("MOUSEMOVE", "NOTHING", **held)

    def key(self, kind, **held):
        self.event(kind, "PRESS", **held)
        self.event(kind, "RELEASE", **held)

    def press(self, **held):
        self.event("LEFTMOUSE", "PRESS", **held)

    def release(self, **held):
        self.event("LEFTMOUSE", "RELEASE", **held)

    def drag(self, pixel, by, steps=4, **held):
        """Presses at a pixel and drags from there; leaves the button pressed."""
        self.move(pixel)
        yield
        self.press(**held)
        yield
        for i in range(1, steps + 1):
            self.move((pixel[0] + by[0] * i / steps, pixel[1] + by[1] * i / steps), **held)
            yield

    def pixel(self, obj, co):
        where = view3d_utils.location_3d_to_region_2d(self.region, self.data, obj.matrix_world @ np_vector(co))
        return int(where[0]), int(where[1])

    def tool(self, name):
        with self.override():
            bpy.ops.wm.tool_set_by_id(name=name)

    def undo(self):
        with self.override():
            bpy.ops.ed.undo()

    def redo(self):
        with self.override():
            bpy.ops.ed.redo()

    def look(self, obj, view="FRONT", closer=1.0):
        """Looks at the object, with the view filled by it."""
        bpy.ops.object.select_all(action="DESELECT")
        obj.select_set(True)
        bpy.context.view_layer.objects.active = obj
        with self.override():
            bpy.ops.view3d.view_axis(type=view)
            bpy.ops.view3d.view_selected()
        self.data.view_distance /= closer
        self.data.update()

    def picture(self, path):
        with self.override():
            bpy.ops.screen.screenshot(filepath=path)


def np_vector(co):
    from mathutils import Vector

    return Vector([float(x) for x in co])


def scene(vertices=5000):
    """Returns a hand that stands upright, alone in the scene."""
    for each in list(bpy.data.objects):
        bpy.data.objects.remove(each)
    obj = make_hand(vertices)
    obj.rotation_euler.x = np.pi / 2
    bpy.context.view_layer.update()
    return obj


def coordinates(obj):
    flat = np.empty(3 * len(obj.data.vertices), np.float32)
    obj.data.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3)


def run(test):
    """Runs the generator from a timer, and leaves Blender."""
    steps = None

    def step():
        nonlocal steps
        try:
            if steps is None:
                steps = test(Window())
            next(steps)
            return _STEP
        except StopIteration:
            print("WINDOW TEST PASSED")
        except BaseException:
            traceback.print_exc()
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(0)  # without the questions of a window that has changes

    bpy.context.preferences.view.show_splash = False
    bpy.context.preferences.system.viewport_aa = "OFF"
    bpy.app.timers.register(step, first_interval=0.5)
