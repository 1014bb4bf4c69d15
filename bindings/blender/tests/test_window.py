"""Run in Blender's window: each tool is started, dragged, typed into, cancelled, undone and repeated by events."""

import json
import os
import sys
import tempfile
import time

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(__file__))
from window_support import PICTURES, coordinates, run, scene

DRAGS = {"move": (40, 50), "snakehook": (40, 50), "pull": (40, 50), "paint": (2, -40), "crease": (2, -40), "pinch": (2, -40), "flatten": (2, -40),  "rotate": (80, 0), "stretch": (80, 40), "twist": (150, 0), "bend": (110, 0),
         "stamp": (10, 0), "pose": (30, -20)}
TYPED = {"move": ("TWO", 0.2), "snakehook": ("TWO", 0.2), "crease": ("TWO", 2), "pinch": ("ONE", 1), "flatten": ("ONE", 1), "pull": ("TWO", 0.2), "rotate": ("FOUR", 4), "stretch": ("NINE", 9), "twist": ("FIVE", 5), "bend": ("SEVEN", 7), "paint": ("ONE", 0.1), "stamp": ("ONE", 0.1),
         "pose": ("ONE", 0.1)}


def is_same(a, b):
    return (a.view(np.uint32) == b.view(np.uint32)).all()


def place_of(window, obj, name):
    """Returns the pixel to press: at the middle of the longest finger."""
    vertices = coordinates(obj)
    tip = vertices[vertices[:, 1].argmax()]
    finger = vertices[(np.abs(vertices[:, 0] - tip[0]) < 0.1) & (vertices[:, 1] > tip[1] - 0.4)]
    return window.pixel(obj, finger.mean(axis=0) if name in ("twist", "bend") else finger.mean(axis=0) + [0, 0.12, 0])


def strokes_of(obj):
    return [json.loads(line) for line in obj.knead.session.splitlines()[1:]]


def dragged(window, name, obj):
    yield from window.drag(place_of(window, obj, name), DRAGS[name])


def check_tool(window, obj, name, mode):
    window.tool(f"knead.{name}_tool")
    yield
    before = coordinates(obj)
    count = len(strokes_of(obj))

    yield from dragged(window, name, obj)  # live, then Esc
    assert not is_same(coordinates(obj), before), f"{name}: the drag moved nothing"
    if PICTURES and mode == "OBJECT":
        for _ in range(4):
            yield
        window.picture(os.path.join(PICTURES, f"{name}.png"))
    window.key("ESC")
    yield
    yield
    window.release()
    yield
    assert is_same(coordinates(obj), before), f"{name}: Esc left something"
    assert len(strokes_of(obj)) == count

    yield from dragged(window, name, obj)  # the right button
    window.event("RIGHTMOUSE", "PRESS")
    yield
    window.event("RIGHTMOUSE", "RELEASE")
    window.release()
    yield
    yield
    assert is_same(coordinates(obj), before), f"{name}: the right button left something"

    yield from dragged(window, name, obj)  # a number
    key, value = TYPED[name]
    if value < 1:
        for each in ("PERIOD", key):
            window.key(each)
            yield
    else:
        window.key(key)
        yield
    window.release()
    for _ in range(4):
        yield
    after, made = coordinates(obj), strokes_of(obj)
    assert len(made) > count, f"{name}: no entry in the session"
    assert not is_same(after, before)
    check_number(name, made[count:], value, before)

    window.undo()
    for _ in range(3):
        yield
    obj = bpy.context.object
    assert is_same(coordinates(obj), before), f"{name}: undo"
    assert len(strokes_of(obj)) == count
    window.redo()
    for _ in range(3):
        yield
    obj = bpy.context.object
    assert is_same(coordinates(obj), after), f"{name}: redo"
    assert strokes_of(obj) == made
    window.undo()  # each tool on the same shape
    for _ in range(2):
        yield


def check_number(name, strokes, value, before):
    """The number that was typed is the stroke's."""
    stroke = strokes[0]
    if name in ("move", "snakehook", "pull"):
        found = np.linalg.norm(np.subtract(stroke["path"][-1], stroke["path"][0]))
    elif name in ("paint", "crease", "pinch", "flatten"):
        from knead_blender.native import knead

        radius = stroke["bump"]
        keys = knead.brush(name, [[0, 0, 0]], radius=radius, amount=value / radius if name == "paint" else value)
        layer = knead.PaintDrag(outer=radius, depth=keys.depth, falloff="wide", pinch=keys.pinch or 0.0)
        layer.touch([0, 0, 0], [0, 0, 1])
        key = "depth" if name == "paint" else "pinch"
        found = value * stroke[key] / getattr(layer.strokes[0], key)
    elif name == "stretch":
        found = 100 * (stroke["factor"] - 1)
    elif name == "twist":
        found = -stroke["rate_deg"] * (stroke["outer"] - stroke["inner"])
    elif name == "pose":
        pin = stroke["parts"][0]
        found = float(np.float32(np.linalg.norm(np.subtract(pin["to"] if "to" in pin else pin["path"][-1], before[pin["pin"]].astype(float)))))
        assert any(part.get("hold") and len(part["vertices"]) for part in stroke["parts"][1:])
    elif name == "stamp":
        return
    else:
        found = abs(stroke["angle_deg"])
    assert abs(found - value) < 1e-6 * max(1, value), f"{name}: {found} instead of {value}"


def check_panel(window, obj):
    """The redo panel changes the last stroke: as F9 and a number do."""
    window.tool("knead.rotate_tool")
    yield
    count = len(strokes_of(obj))
    before = coordinates(obj)
    yield from dragged(window, "rotate", obj)
    window.release()
    for _ in range(4):
        yield
    if PICTURES and obj.mode == "OBJECT":
        window.move(window.pixel(obj, coordinates(obj).mean(axis=0)))
        yield
        window.key("F9")
        for _ in range(6):
            yield
        window.picture(os.path.join(PICTURES, "redo.png"))
        window.key("ESC")
        for _ in range(2):
            yield
    operator = bpy.context.window_manager.operators[-1]
    assert operator.bl_idname == "KNEAD_OT_rotate", operator.bl_idname
    first = coordinates(bpy.context.object)
    operator.angle_deg = 12
    with window.override():
        assert bpy.ops.ed.undo_redo.poll() and bpy.ops.ed.undo_redo() == {"FINISHED"}
    for _ in range(3):
        yield
    obj = bpy.context.object
    made = strokes_of(obj)
    assert len(made) == count + 1, made
    changed = coordinates(obj)
    assert not is_same(changed, first) and not is_same(changed, before)
    assert abs(made[-1]["angle_deg"] - 12) < 1e-5

    bpy.context.window_manager.operators[-1].strength = 0.5
    with window.override():
        bpy.ops.ed.undo_redo()
    for _ in range(3):
        yield
    assert strokes_of(bpy.context.object)[-1]["strength"] == 0.5
    yield from dragged(window, "rotate", bpy.context.object)  # begins anew: without what the panel changed
    window.release()
    for _ in range(4):
        yield
    after = coordinates(bpy.context.object)
    assert "strength" not in strokes_of(bpy.context.object)[-1]
    with window.override():
        bpy.ops.ed.undo_redo()
    for _ in range(3):
        yield
    assert is_same(coordinates(bpy.context.object), after), "a repetition has other bits"


def check_rings_and_keys(window, obj):
    settings = bpy.context.scene.knead
    pixel = place_of(window, obj, "pull")
    window.move(pixel)
    yield
    for kind, shift, setting in (("F", False, "radius"), ("F", True, "inner_ratio")):
        old = getattr(settings, setting)
        window.key(kind, shift=shift)
        yield
        window.move((pixel[0] + 60, pixel[1]))
        yield
        assert getattr(settings, setting) > old, setting
        window.key("ESC")
        yield
        assert getattr(settings, setting) == old
        window.move(pixel)
        yield
        window.key(kind, shift=shift)
        yield
        for each in ("PERIOD", "TWO"):
            window.key(each)
            yield
        window.key("RET")
        yield
        assert abs(getattr(settings, setting) - 0.2) < 1e-6
        setattr(settings, setting, old)


def check_background(window):
    """A long rebuild and a long bake live beside the window; Esc stops them."""
    from knead_blender.background import Job

    stops, stop = [], Job.stop

    def timed(job):
        start = time.perf_counter()
        stop(job)
        stops.append(time.perf_counter() - start)

    Job.stop = timed
    obj = scene(40000)
    window.look(obj)
    tip = coordinates(obj)[coordinates(obj)[:, 1].argmax()].tolist()
    turn = {"tool": "rotate", "center": tip, "axis": [1, 0.2, 0], "angle_deg": 0.5, "inner": 0.1, "outer": 1.5}
    with tempfile.TemporaryDirectory() as folder:
        path = os.path.join(folder, "long.knead")
        with open(path, "w") as file:
            file.write("\n".join(json.dumps(line) for line in [{"knead": 1}] + [turn] * 2000) + "\n")
        with window.override():
            bpy.ops.knead.apply_session(filepath=path)
    after, text = coordinates(obj), obj.knead.session
    with window.override():
        assert bpy.ops.knead.session_rebuild("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    yield
    window.key("ESC")
    for _ in range(20):
        if not stops:
            yield
    assert stops.pop() < 2  # seconds; half a second where the machine has nothing else to do
    assert is_same(coordinates(obj), after) and obj.knead.session == text
    obj.data.knead.strokes[0].name = "untouched"
    with window.override():
        assert bpy.ops.knead.session_rebuild("INVOKE_DEFAULT") == {"RUNNING_MODAL"}
    deadline, waits = time.perf_counter() + 60, 0
    while obj.data.knead.strokes[0].name == "untouched":  # the list is made anew at the end
        assert time.perf_counter() < deadline
        waits += 1
        yield
    assert waits > 5, "the rebuild was too short to be stopped above"
    assert is_same(coordinates(obj), after)
    with window.override():
        bpy.ops.knead.bake("INVOKE_DEFAULT", frames=50)
    for _ in range(3):
        yield
    window.key("RET")  # the dialog
    for _ in range(2):
        yield
    window.key("ESC")
    for _ in range(20):
        if not stops:
            yield
    assert stops.pop() < 2  # seconds; half a second where the machine has nothing else to do
    for _ in range(3):
        yield
    assert obj.data.shape_keys is None and is_same(coordinates(obj), after)
    Job.stop = stop


def test(window):
    for mode in ("OBJECT", "SCULPT"):
        obj = scene()
        window.look(obj)
        bpy.context.preferences.edit.undo_steps = 64
        wrist = [i for i, p in enumerate(coordinates(obj)) if p[1] < -0.5]
        obj.vertex_groups.new(name="wrist").add(wrist, 1.0, "REPLACE")
        bpy.context.scene.knead.pose_hold = "wrist"
        with window.override():
            bpy.ops.object.mode_set(mode=mode)
            bpy.ops.ed.undo_push(message="start")
        yield
        for name in list(DRAGS) if mode == "OBJECT" else ("pull", "paint"):  # the rest is the same in both
            yield from check_tool(window, bpy.context.object, name, mode)
            print(mode, name, "passed", flush=True)
        if mode == "OBJECT":
            yield from check_rings_and_keys(window, bpy.context.object)
        yield from check_panel(window, bpy.context.object)
        print(mode, "panel passed", flush=True)
    yield from check_background(window)
    print("background passed", flush=True)
    yield from check_disable(window)


def check_disable(window):
    """Disable and enable again: tools, keys and properties go and come back."""
    for _ in range(2):
        bpy.ops.preferences.addon_disable(module="knead_blender")
        for _ in range(2):
            window.move((window.region.width // 2, window.region.height // 2))
            yield
        tool = window.window.workspace.tools.from_space_view3d_mode(bpy.context.mode, create=False)
        assert not tool.idname.startswith("knead."), tool.idname
        assert not hasattr(bpy.types.Scene, "knead") and "KNEAD_OT_pull" not in dir(bpy.types)
        bpy.ops.preferences.addon_enable(module="knead_blender")
        yield
        assert "KNEAD_OT_pull" in dir(bpy.types)
        window.tool("knead.pull_tool")
        yield


run(test)
