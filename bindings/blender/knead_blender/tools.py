# SPDX-License-Identifier: GPL-3.0-or-later
"""The modal tools: press on the surface, drag, release; and the radius by key."""

import bpy
from bpy.props import EnumProperty, StringProperty

from . import gestures, keys, live, rings, shape, stamps, state, view
from .native import knead

_ERRORS = (state.Refusal, ValueError, RuntimeError, OSError)
_DIGITS = dict(zip("ZERO ONE TWO THREE FOUR FIVE SIX SEVEN EIGHT NINE".split(), "0123456789"))
_SIGNS = {"PERIOD": ".", "COMMA": ".", "NUMPAD_PERIOD": ".", "MINUS": "-", "NUMPAD_MINUS": "-"}

active = None  # the stroke that is being made: what the ring's drawing looks at


class Typed:
    """A number that is typed while something is dragged."""

    def __init__(self):
        self.text = ""

    def take(self, event):
        """Returns whether the event belongs to the number."""
        if event.value != "PRESS":
            return False
        digit = _DIGITS.get(event.type.replace("NUMPAD_", "")) or _SIGNS.get(event.type)
        if event.type == "BACK_SPACE" and self.text:
            self.text = self.text[:-1]
        elif digit == "-":
            self.text = self.text[1:] if self.text.startswith("-") else "-" + self.text
        elif digit is not None:
            self.text += digit if digit != "." or "." not in self.text else ""
        else:
            return False
        return True

    @property
    def value(self):
        try:
            return float(self.text)
        except ValueError:
            return None


def mirrors(obj):
    """Returns the planes in which the object's own symmetry mirrors."""
    return {axis.upper() for axis in "xyz" if getattr(obj.data, f"use_mirror_{axis}")}


class Tool:
    """An operator that drags a tool over the surface; its properties are the keys of the stroke."""

    bl_options = {"REGISTER", "UNDO"}
    made: StringProperty(options={"HIDDEN"})
    mirror: EnumProperty(
        name="Mirror",
        description="Images in the object's own coordinate planes",
        options={"ENUM_FLAG"},
        items=[("X", "X", ""), ("Y", "Y", ""), ("Z", "Z", "")],
    )

    @classmethod
    def poll(cls, context):
        obj = context.object
        return obj is not None and obj.type == "MESH" and obj.mode in {"OBJECT", "SCULPT"}

    def draw(self, context):
        column = self.layout.column()
        column.use_property_split = True
        for name in keys.shown(self, self.gesture_class.cls):
            column.prop(self, name)
        column.row(heading="Mirror").prop(self, "mirror")

    def _with_images(self, strokes):
        return knead.symmetric(strokes, "".join(sorted(self.mirror)).lower())

    def execute(self, context):
        obj = context.object
        try:
            shape_of = live.begin(obj)
            before = shape.read(obj)
            strokes = self._with_images(keys.read(self, self.gesture_class.cls))
            shape_of.set_strokes(strokes)
            live.keep(self, obj, shape_of, strokes, before)
        except _ERRORS as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}

    def invoke(self, context, event):
        global active
        if context.region_data is None:
            return self.execute(context)
        obj = context.object
        try:
            self._live = live.begin(obj)
            self._view = view.View(context.region, context.region_data, obj, self._live.frame)
            pointer = self._pointer(event)
            hit = self._live.surface.hit(*self._view.ray(pointer.pixel))
            if hit is None:
                return {"PASS_THROUGH"}
            self._gesture = self.gesture_class(self._view, self._live, context.scene.knead, pointer, hit)
        except _ERRORS as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._obj, self._before, self._typed, self._trouble = obj, shape.read(obj), Typed(), ""
        self.mirror = mirrors(obj)
        self._draw_handler = bpy.types.SpaceView3D.draw_handler_add(self._draw_rings, (), "WINDOW", "POST_PIXEL")
        active = self
        context.window_manager.modal_handler_add(self)
        self._update(context, pointer)
        return {"RUNNING_MODAL"}

    def _pointer(self, event, typed=None):
        region = self._view.region
        pixel = event.mouse_x - region.x, event.mouse_y - region.y
        pressure = event.pressure if event.is_tablet else 1.0
        return gestures.Pointer(pixel, event.ctrl, pressure, typed)

    def modal(self, context, event):
        try:
            return self._modal(context, event)
        except Exception as error:  # whatever it is, the mesh is as it was before the stroke
            self.report({"ERROR"}, str(error))
            return self._cancel(context)

    def _modal(self, context, event):
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            return self._cancel(context)
        if self._typed.take(event) or event.type in {"MOUSEMOVE", "INBETWEEN_MOUSEMOVE", "LEFT_CTRL", "RIGHT_CTRL"}:
            self._update(context, self._pointer(event, self._typed.value))
        elif (event.type == "LEFTMOUSE" and event.value == "RELEASE") or (
            event.type in {"RET", "NUMPAD_ENTER"} and event.value == "PRESS"
        ):
            return self._finish(context, self._pointer(event, self._typed.value))
        return {"RUNNING_MODAL"}

    def _update(self, context, pointer):
        self._gesture.move(pointer)
        try:
            self._live.set_strokes(self._with_images(self._gesture.strokes()))
            self._trouble = ""
        except _ERRORS as error:
            self._trouble = str(error)
        live.show(self._obj, self._live)
        amount = f"{self._gesture.amount():.4g}{self._gesture.unit}"
        typed = f" [{self._typed.text}|]" if self._typed.text else ""
        context.area.header_text_set(f"{self.bl_label}: {amount}{typed}   {self._trouble or _HELP}")
        context.area.tag_redraw()

    def _draw_rings(self):
        point, normal, radii = self._gesture.ring_at()
        rings.draw(self._view, rings.of(self._live.surface, point, normal, radii))

    def _leave(self, context):
        global active
        active = None
        bpy.types.SpaceView3D.draw_handler_remove(self._draw_handler, "WINDOW")
        context.area.header_text_set(None)
        context.area.tag_redraw()

    def _cancel(self, context):
        self._leave(context)
        self._live.set_strokes([])
        shape.write(self._obj, self._before)
        return {"CANCELLED"}

    def _finish(self, context, pointer):
        self._gesture.move(pointer)
        self._gesture.end()
        try:
            strokes = self._gesture.strokes()
            if not strokes:
                self._gesture.click()
                return self._cancel(context)
            self._live.set_strokes(self._with_images(strokes))
        except _ERRORS as error:
            self.report({"WARNING"}, str(error))
            return self._cancel(context)
        keys.write(self, self.gesture_class.cls, strokes)
        live.keep(self, self._obj, self._live, self._with_images(strokes), self._before)
        self._leave(context)
        return {"FINISHED"}


_HELP = "Type a number; Ctrl snaps; Esc cancels"


def _operator(name, label, help_text):
    gesture = gestures.ALL[name]
    made = {"made": Tool.__annotations__["made"], **keys.properties(gesture.cls), "mirror": Tool.__annotations__["mirror"]}
    body = {
        "__annotations__": made,
        "__doc__": help_text,
        "bl_idname": f"knead.{name}",
        "bl_label": label,
        "gesture_class": gesture,
    }
    return type(f"KNEAD_OT_{name}", (Tool, bpy.types.Operator), body)


class Radial:
    """Changes a number of the scene's settings by a drag to the right or left."""

    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        return Tool.poll(context) and context.region_data is not None

    def invoke(self, context, event):
        self._start, self._typed = event.mouse_x, Typed()
        self._before = getattr(context.scene.knead, self.setting)
        context.window_manager.modal_handler_add(self)
        self._show(context)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        settings = context.scene.knead
        if event.type in {"ESC", "RIGHTMOUSE"} and event.value == "PRESS":
            setattr(settings, self.setting, self._before)
            return self._end(context, {"CANCELLED"})
        if event.type in {"LEFTMOUSE", "RET", "NUMPAD_ENTER"} and event.value == "PRESS":
            return self._end(context, {"FINISHED"})
        if self._typed.take(event) or event.type == "MOUSEMOVE":
            dragged = self._before * 2 ** ((event.mouse_x - self._start) / 150)
            value = self._typed.value
            setattr(settings, self.setting, dragged if value is None else value)
            self._show(context)
        return {"RUNNING_MODAL"}

    def _show(self, context):
        context.area.header_text_set(f"{self.bl_label}: {getattr(context.scene.knead, self.setting):.4g} {self._typed.text}")
        context.area.tag_redraw()

    def _end(self, context, result):
        context.area.header_text_set(None)
        context.area.tag_redraw()
        return result


class KNEAD_OT_radius(Radial, bpy.types.Operator):
    """Change the radius of the tools, a fraction of the mesh's diagonal"""

    bl_idname = "knead.radius"
    bl_label = "Radius"
    setting = "radius"


class KNEAD_OT_inner(Radial, bpy.types.Operator):
    """Change the part of the radius that follows a tool as a whole"""

    bl_idname = "knead.inner"
    bl_label = "Inner Ratio"
    setting = "inner_ratio"


OPERATORS = (
    _operator("move", "Move", "Move the surface along with the pointer, and fill it up from far around"),
    _operator("snakehook", "Snakehook", "Pull out a horn or a tail that ends in a point"),
    _operator("paint", "Paint", "Paint the surface up, or with Ctrl down"),
    _operator("crease", "Crease", "Draw a sharp crease, or with Ctrl a sharp ridge"),
    _operator("pinch", "Pinch", "Draw the surface together, so that edges grow sharp; with Ctrl apart"),
    _operator("flatten", "Flatten", "Press bumps and dents to a plane; with Ctrl make them stronger"),
    _operator("pull", "Pull", "Pull a ball of the mesh along the pointer's path"),
    _operator("rotate", "Rotate", "Turn a ball of the mesh"),
    _operator("stretch", "Stretch", "Stretch a ball of the mesh along its normal"),
    _operator("twist", "Twist", "Twist a part of the mesh"),
    _operator("bend", "Bend", "Bend a part of the mesh"),
    _operator("stamp", "Stamp", "Press a closed mesh into the surface"),
    _operator("pose", "Pose", "Drag a place; what is pinned stays, the rest follows as if it had bones. A click pins or frees"),
)
_CLASSES = (*OPERATORS, KNEAD_OT_radius, KNEAD_OT_inner)


def register():
    for cls in _CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    live.forget()
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
