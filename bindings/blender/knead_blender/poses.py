# SPDX-License-Identifier: GPL-3.0-or-later
"""Poses: what of a mesh holds, what moves, and the operators that say so."""

import json

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, FloatVectorProperty, StringProperty

from . import compat, operators, shown, state
from .native import knead

_PART_WEIGHT = 0.5  # the weight from which on a vertex belongs to a part


def of_group(obj, name):
    """Returns the numbers of the vertices with at least half of the weight in a vertex group."""
    group = obj.vertex_groups.get(name)
    if group is None:
        raise state.Refusal(f"The object has no vertex group {name}")
    weighed = ((v.index, g.weight) for v in obj.data.vertices for g in v.groups if g.group == group.index)
    return np.array([index for index, weight in weighed if weight >= _PART_WEIGHT], int)


def of_sculpt_mask(obj):
    """Returns the numbers of the vertices that the sculpt mask covers by half or more."""
    data = compat.sculpt_mask(obj.data)
    values = np.zeros(len(obj.data.vertices), np.float32)
    if data is not None:
        data.foreach_get("value", values)
    return np.flatnonzero(values >= _PART_WEIGHT)


def of_selection(obj):
    chosen = np.empty(len(obj.data.vertices), bool)
    obj.data.vertices.foreach_get("select", chosen)
    return np.flatnonzero(chosen)


def pins(obj):
    """Returns the numbers of the vertices that are pinned, as far as the mesh has them."""
    return [v for v in json.loads(obj.data.knead.pins or "[]") if v < len(obj.data.vertices)]


def set_pins(obj, numbers):
    obj.data.knead.pins = json.dumps(sorted({int(v) for v in numbers}))


def held(obj, fixed, moving):
    """Returns the parts that hold: the vertices in `fixed` and the pins, without the moving vertices."""
    moving = {int(v) for v in moving}
    fixed = [int(v) for v in fixed if int(v) not in moving]
    parts = [{"vertices": np.array(fixed), "hold": True}] if fixed else []
    inside = moving.union(fixed)
    return parts + [{"pin": v, "hold": True} for v in pins(obj) if v not in inside]


class KNEAD_OT_pose_pins(operators.Plain, bpy.types.Operator):
    """Pin vertices: they stay while other places are posed"""

    bl_idname = "knead.pose_pins"
    bl_label = "Pin"
    at: EnumProperty(
        name="At",
        items=[
            ("CURSOR", "3D Cursor", "The vertex nearest to the 3D cursor"),
            ("SELECTED", "Selected", "All selected vertices"),
            ("NONE", "None", "No vertex; with Replace all pins are taken away"),
        ],
    )
    replace: BoolProperty(name="Replace", description="Take away the pins that there are")

    def work(self, context, obj):
        numbers = [] if self.replace else pins(obj)
        if self.at == "SELECTED":
            numbers = [*numbers, *of_selection(obj)]
        elif self.at == "CURSOR":
            place = np.array(obj.matrix_world.inverted_safe() @ context.scene.cursor.location)
            numbers = [*numbers, np.linalg.norm(shown.read(obj) - place, axis=1).argmin()]
        if len(numbers) > 1000:
            raise state.Refusal(f"A pose holds at most 1000 pins, and {len(numbers)} vertices would be pinned; use a vertex group")
        set_pins(obj, numbers)


class KNEAD_OT_pose_part(operators.Plain, bpy.types.Operator):
    """Move a part rigidly; the rest follows as nearly rigidly as it can, and keeps its volume"""

    bl_idname = "knead.pose_part"
    bl_label = "Pose Part"
    part: EnumProperty(
        name="Part",
        items=[
            ("GROUP", "Vertex Group", "The vertices with at least half of the weight"),
            ("MASK", "Sculpt Mask", "What the sculpt mask covers"),
            ("SELECTED", "Selected", "The selected vertices"),
        ],
    )
    group: StringProperty(name="Vertex Group", description="That moves; empty: the active one")
    hold: StringProperty(name="Hold", description="The vertex group that stays, besides the pins")
    translate: FloatVectorProperty(name="Move", size=3, precision=4, subtype="TRANSLATION")
    axis: FloatVectorProperty(name="Axis", size=3, precision=4, default=(0, 0, 1))
    angle_deg: FloatProperty(name="Angle", description="Degrees about the axis", default=0)
    use_cursor: BoolProperty(name="About the 3D Cursor", default=True)
    center: FloatVectorProperty(name="Center", size=3, precision=4)
    detail: FloatProperty(name="Detail", description="The finest motion, of the mesh's diagonal; 0: from the thickness", default=0, min=0, max=0.5)
    exact: BoolProperty(name="Exact", description="The part goes exactly to its place, by a last stroke of pins")

    def draw(self, context):
        column = self.layout.column()
        column.use_property_split = True
        column.prop(self, "part")
        if self.part == "GROUP":
            column.prop_search(self, "group", context.object, "vertex_groups")
        column.prop_search(self, "hold", context.object, "vertex_groups")
        for name in ("translate", "angle_deg", "axis", "use_cursor"):
            column.prop(self, name)
        if not self.use_cursor:
            column.prop(self, "center")
        column.prop(self, "detail")
        column.prop(self, "exact")

    def work(self, context, obj):
        moving = self._moving(obj)
        if len(moving) == 0:
            raise state.Refusal("The part has no vertices; choose a group with weights, a sculpt mask, or select vertices")
        fixed = held(obj, of_group(obj, self.hold) if self.hold else [], moving)
        if not fixed:
            raise state.Refusal("Nothing holds; name a vertex group that stays, or pin vertices")
        stroke = knead.Pose(parts=[{"vertices": moving, **self._motion(context, obj)}, *fixed], **self._numbers())
        operators.append(self, obj, [stroke])

    def _moving(self, obj):
        if self.part == "MASK":
            return of_sculpt_mask(obj)
        if self.part == "SELECTED":
            return of_selection(obj)
        active = obj.vertex_groups.active
        if not self.group and active is None:
            raise state.Refusal("The object has no vertex group; name one, or choose another part")
        return of_group(obj, self.group or active.name)

    def _motion(self, context, obj):
        motion = {"translate": list(self.translate)} if any(self.translate) else {}
        if self.angle_deg:
            cursor = obj.matrix_world.inverted_safe() @ context.scene.cursor.location
            center = list(cursor if self.use_cursor else self.center)
            motion.update(rotate=list(self.axis), center=center, angle_deg=self.angle_deg)
        if not motion:
            raise state.Refusal("The part does not move; give a way, or an angle")
        return motion

    def _numbers(self):
        numbers = {} if self.detail == 0 else {"detail": round(self.detail, 6)}
        return {**numbers, "exact": True} if self.exact else numbers


_CLASSES = (KNEAD_OT_pose_pins, KNEAD_OT_pose_part)


def register():
    for cls in _CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
