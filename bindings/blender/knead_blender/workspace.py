# SPDX-License-Identifier: GPL-3.0-or-later
"""The tools in the tool bar, in object and sculpt mode, with icons and key map."""

import os

import bpy
import numpy as np
from bpy_extras import view3d_utils

from . import compat, gestures, live, rings, tools, view

_ICONS = os.path.join(os.path.dirname(__file__), "icons")
_PINCHES = ("radius", "pinch", "pressure")
_OF_TOOL = {
    "move": ("radius",),
    "snakehook": ("radius",),
    "paint": ("radius", "depth", "pressure"),
    "crease": _PINCHES,
    "pinch": _PINCHES,
    "flatten": _PINCHES,
    "twist": ("radius", "whole_part", "widen_zone"),
    "bend": ("radius", "whole_part", "widen_zone"),
    "pose": ("pose_hold", "pose_detail"),
    "stamp": ("radius", "stamp", "stamp_size"),
}


def _draw_settings(name):
    def draw_settings(context, layout, tool):
        has_falloff = name != "pose" and not hasattr(gestures.ALL[name], "brush")
        for setting in (*_OF_TOOL.get(name, ("radius", "inner_ratio")), *(("falloff",) if has_falloff else ())):
            layout.prop(context.scene.knead, setting)

    return draw_settings


def _region_at(context, xy):
    for area in context.window.screen.areas:
        if area.type == "VIEW_3D":
            for region in area.regions:
                inside = 0 <= xy[0] - region.x < region.width and 0 <= xy[1] - region.y < region.height
                if region.type == "WINDOW" and inside:
                    return region, area.spaces.active.region_3d
    return None, None


def _hit(obj, region, data, pixel):
    """Returns where the pixel's ray meets the object as Blender shows it, in its own space."""
    inverse = obj.matrix_world.inverted_safe()
    origin = inverse @ view3d_utils.region_2d_to_origin_3d(region, data, pixel)
    direction = inverse.to_3x3() @ view3d_utils.region_2d_to_vector_3d(region, data, pixel)
    found, point, normal, _ = obj.ray_cast(origin, direction)
    return (np.array(point), np.array(normal)) if found else None


def _draw_cursor(context, tool, xy):
    """Draws the rings where the pointer is: on the surface where the library has it, else flat."""
    obj = context.object
    region, data = _region_at(context, xy)
    if not _registered or tools.active is not None or region is None or not tools.Tool.poll(context):
        return
    pixel = xy[0] - region.x, xy[1] - region.y
    kept = live.touched(obj)
    frame = kept.frame if kept else live.shape.Frame()
    seen = view.View(region, data, obj, frame)
    hit = kept.surface.hit(*seen.ray(pixel)) if kept else _hit(obj, region, data, pixel)
    if hit is None:
        return
    corners = np.array(obj.bound_box)
    size = kept.size if kept else float(np.linalg.norm(np.ptp(corners, axis=0)))
    radius = context.scene.knead.radius * size
    is_brush = hasattr(gestures.ALL[tool.idname.split(".")[1].removesuffix("_tool")], "brush")
    radii = (radius,) if is_brush else (radius, radius * context.scene.knead.inner_ratio)
    found = rings.of(kept.surface, *hit, radii) if kept else rings.flat(*hit, radii)
    rings.draw(seen, found)


def _tool(operator, mode):
    name = operator.bl_idname.split(".")[1]
    press = {"type": "LEFTMOUSE", "value": "PRESS"}
    body = {
        "bl_space_type": "VIEW_3D",
        "bl_context_mode": mode,
        "bl_idname": f"knead.{name}_tool",
        "bl_label": f"Knead {operator.bl_label}",
        "bl_description": operator.__doc__,
        "bl_icon": os.path.join(_ICONS, name),
        "bl_cursor": "CROSSHAIR",
        "bl_keymap": (
            (operator.bl_idname, press, None),
            (operator.bl_idname, {**press, "ctrl": True}, None),
            ("knead.radius", {"type": "F", "value": "PRESS"}, None),
            ("knead.inner", {"type": "F", "value": "PRESS", "shift": True}, None),
        ),
        "draw_settings": staticmethod(_draw_settings(name)),
        "draw_cursor": staticmethod(_draw_cursor),
    }
    return type(f"KNEAD_WT_{name}_{mode.lower()}", (bpy.types.WorkSpaceTool,), body)


_registered = []


def register():
    if bpy.app.background:
        return  # there is no tool bar
    for mode in ("OBJECT", "SCULPT"):
        for i, operator in enumerate(tools.OPERATORS):
            tool = _tool(operator, mode)
            bpy.utils.register_tool(tool, separator=i == 0)
            _registered.append(tool)


def _leave_tools():
    """Chooses Blender's own tool where one of Knead's is active, so that none stays without its operator."""
    for window in bpy.context.window_manager.windows:
        for area in (a for a in window.screen.areas if a.type == "VIEW_3D"):
            tool = window.workspace.tools.from_space_view3d_mode(bpy.context.mode, create=False)
            if tool is not None and tool.idname.startswith("knead."):
                region = next(r for r in area.regions if r.type == "WINDOW")
                with bpy.context.temp_override(window=window, area=area, region=region):
                    bpy.ops.wm.tool_set_by_id(name="builtin.select_box" if bpy.context.mode == "OBJECT" else compat.sculpt_tool())


def unregister():
    if _registered:
        _leave_tools()
    while _registered:
        bpy.utils.unregister_tool(_registered.pop())
