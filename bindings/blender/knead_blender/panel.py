# SPDX-License-Identifier: GPL-3.0-or-later
"""The tab Knead in the sidebar of the 3D view."""

import bpy

from . import poses


class KNEAD_UL_strokes(bpy.types.UIList):
    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index):
        row = layout.row(align=True)
        row.prop(item, "on", text="")
        row.label(text=f"{index + 1}  {item.name}")


class KNEAD_PT_session(bpy.types.Panel):
    bl_label = "Knead"
    bl_category = "Knead"
    bl_space_type = "VIEW_3D"
    bl_region_type = "UI"

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == "MESH"

    def draw(self, context):
        layout, obj = self.layout, context.object
        data = obj.data.knead
        if obj.mode not in {"OBJECT", "SCULPT"}:
            layout.label(text="Leave this mode to use Knead", icon="INFO")
            return
        row = layout.row()
        row.template_list("KNEAD_UL_strokes", "", data, "strokes", data, "active", rows=4)
        if data.session:
            self._stroke_buttons(row.column(align=True), data)
        column = layout.column(align=True)
        column.operator("knead.apply_session", icon="FILE_FOLDER")
        row = column.row(align=True)
        row.operator("knead.session_import", text="Import")
        row.operator("knead.session_export", text="Export")
        row = column.row(align=True)
        row.operator("knead.session_rebuild")
        row.operator("knead.session_clear", text="Clear")
        row = layout.row(align=True)
        row.operator("knead.add_mask")
        row.operator("knead.remove_mask")
        self._pose_buttons(layout, obj)
        layout.operator("knead.fit")
        layout.operator("knead.bend_along", icon="CURVE_DATA")
        layout.operator("knead.take_along")
        layout.operator("knead.make_corrective", icon="ARMATURE_DATA")
        layout.operator("knead.bake")
        layout.operator("knead.check")
        for line in obj.knead.report.splitlines():
            layout.label(text=line)

    @staticmethod
    def _pose_buttons(layout, obj):
        column = layout.column(align=True)
        column.operator("knead.pose_part", icon="POSE_HLT")
        row = column.row(align=True)
        row.operator("knead.pose_pins", text="Pin at Cursor").at = "CURSOR"
        row.operator("knead.pose_pins", text="Selected").at = "SELECTED"
        clear = row.operator("knead.pose_pins", text=f"Unpin {len(poses.pins(obj))}")
        clear.at, clear.replace = "NONE", True

    @staticmethod
    def _stroke_buttons(column, data):
        i = data.active
        column.operator("knead.stroke_edit", text="", icon="GREASEPENCIL").index = i
        column.operator("knead.stroke_remove", text="", icon="REMOVE").index = i
        for to, icon in ((i - 1, "TRIA_UP"), (i + 1, "TRIA_DOWN")):
            row = column.row()
            row.enabled = 0 <= to < len(data.strokes)
            button = row.operator("knead.stroke_move", text="", icon=icon)
            button.index, button.to = i, max(0, to)


def register():
    bpy.utils.register_class(KNEAD_UL_strokes)
    bpy.utils.register_class(KNEAD_PT_session)


def unregister():
    bpy.utils.unregister_class(KNEAD_PT_session)
    bpy.utils.unregister_class(KNEAD_UL_strokes)
