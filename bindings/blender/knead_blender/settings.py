# SPDX-License-Identifier: GPL-3.0-or-later
"""What is set for the tools, with the scene."""

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, PointerProperty, StringProperty


class KneadTools(bpy.types.PropertyGroup):
    radius: FloatProperty(
        name="Radius",
        description="Where a tool ends: a fraction of the diagonal of the mesh",
        default=0.1,
        min=0.001,
        max=2,
        subtype="FACTOR",
    )
    inner_ratio: FloatProperty(
        name="Inner",
        description="The part of the radius that follows a tool as a whole",
        default=0.35,
        min=0.01,
        max=0.95,
        subtype="FACTOR",
    )
    falloff: IntProperty(name="Falloff", description="The shape of the blend between both", default=4, min=3, max=7)
    depth: FloatProperty(
        name="Depth", description="Of a layer of paint: a fraction of the radius", default=0.15, min=0.005, max=1
    )
    pinch: FloatProperty(
        name="Strength", description="Of a layer of a crease, pinch or flatten: the logarithm by which it thins the surface", default=0.7, min=0.05, max=2
    )
    pressure: EnumProperty(
        name="Pressure",
        description="What a pen's pressure changes while it paints",
        items=[
            ("NONE", "Nothing", "The pressure does not matter"),
            ("DEPTH", "Depth", "A light pen paints less"),
            ("RADIUS", "Radius", "A light pen paints finer"),
        ],
        default="DEPTH",
    )
    whole_part: BoolProperty(
        name="One Part",
        description="Twist and bend move one part alone, such as an arm, which Knead finds; else all beyond the place",
        default=True,
    )
    widen_zone: BoolProperty(
        name="Widen",
        description="Spread a twist or bend over more of the part where it would stretch that too much",
        default=True,
    )
    pose_hold: StringProperty(
        name="Hold", description="The vertex group that stays while a place is posed; empty: what the sculpt mask covers"
    )
    pose_detail: FloatProperty(
        name="Detail",
        description="The finest motion of a pose: a fraction of the diagonal of the mesh",
        default=0.075,
        min=0.02,
        max=0.3,
    )
    stamp: PointerProperty(
        name="Stamp",
        description="The closed mesh that is pressed in; none: a ball",
        type=bpy.types.Object,
        poll=lambda self, obj: obj.type == "MESH",
    )
    stamp_size: FloatProperty(
        name="Size", description="Half the extent of the stamp: a fraction of the radius", default=0.5, min=0.05, max=3
    )


def register():
    bpy.utils.register_class(KneadTools)
    bpy.types.Scene.knead = PointerProperty(type=KneadTools)


def unregister():
    del bpy.types.Scene.knead
    bpy.utils.unregister_class(KneadTools)
