# SPDX-License-Identifier: GPL-3.0-or-later
"""knead.bake: the motion of a session as shape keys, or as a PC2 file with the modifier Mesh Cache."""

import os

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

from . import compat, rebuild, shape, state
from .background import Background
from .native import knead
from .operators import OfSession


ALONG = "knead_along"


def frames_of(obj, count):
    """Returns a function of `progress` for the coordinates at `count` moments, evenly spaced in time from the base to the
    end of the session; it returns None where `progress` ended it."""
    session = state.parse(obj.knead.session)
    rebuild.check_session(session)
    base = shape.read_base(obj.data)
    if base is None:
        raise state.Refusal("The base positions are gone, or the mesh has other vertices now")
    frame, faces = state.frame_of(obj.data), shape.faces(obj.data)
    entered = frame.enter(base)

    def work(progress=None):
        frames = knead.frames(entered, session, count, faces, progress=progress)
        return None if frames is None else [frame.leave(moved, entered, base) for moved in frames]

    return work


class KNEAD_OT_bake(Background, OfSession, bpy.types.Operator):
    """Make an animation of the session; Esc stops"""

    bl_idname = "knead.bake"
    bl_label = "Bake Animation"
    frames: IntProperty(name="Frames", default=24, min=2, max=1000)
    to: EnumProperty(
        name="To",
        items=[
            ("SHAPE_KEYS", "Shape Keys", "A shape key for each frame"),
            ("MESH_CACHE", "Mesh Cache", "A PC2 file and the modifier Mesh Cache"),
        ],
    )
    drive: EnumProperty(
        name="Driven by",
        description="What moves shape keys",
        items=[
            ("KEYFRAMES", "Keyframes", "The time, from the scene's first frame on"),
            ("PROPERTY", "Property", "The object's property knead_along, from 0 to 1, by drivers: for a rig"),
        ],
    )
    filepath: StringProperty(name="File", subtype="FILE_PATH", description="The PC2 file; empty: beside the .blend file")
    _in_window = False

    def invoke(self, context, event):
        self._in_window = True
        return context.window_manager.invoke_props_dialog(self)

    def execute(self, context):
        if not self._in_window:
            return super().execute(context)
        self._in_window = False  # a repetition waits
        obj = context.object
        try:
            state.require_mesh(obj)
            self._require(obj)
            return self.start(context, obj, frames_of(obj, self.frames))
        except (state.Refusal, ValueError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}

    def work(self, context, obj):
        self._require(obj)
        self.finish(context, obj, frames_of(obj, self.frames)())

    def _require(self, obj):
        if obj.data.knead.is_posed:
            raise state.Refusal("The session was made on a posed mesh, whose motion cannot be baked; the shape key has its end")
        state.require_own_key(obj)
        if state.changed_elsewhere(obj):
            raise state.Refusal("The mesh was changed elsewhere, which the animation would lack; rebuild it, or clear the session")
        if self.to == "MESH_CACHE":
            self._path(obj)
        elif obj.data.shape_keys is not None:
            raise state.Refusal("The mesh has shape keys; bake to a mesh cache, or remove them first")

    def finish(self, context, obj, frames):
        start = context.scene.frame_start
        if self.to == "MESH_CACHE":
            path = self._path(obj)
            knead.write_frames(path, frames)
            self._add_modifier(obj, path, start)
        else:
            self._add_moving_keys(obj, frames, start)
        if self.to == "MESH_CACHE" or self.drive == "KEYFRAMES":
            context.scene.frame_end = max(context.scene.frame_end, start + len(frames) - 1)
            context.scene.frame_set(start + len(frames) - 1)  # where the mesh is as it was before
        if self.to == "SHAPE_KEYS":
            state.note_result(obj)

    def _add_moving_keys(self, obj, frames, start):
        """Adds the keys and what moves them, or nothing. The session goes on with the last key."""
        before = shape.read(obj)
        try:
            self._add_keys(obj, frames)
            self._add_drivers(obj, len(frames)) if self.drive == "PROPERTY" else self._add_keyframes(obj, len(frames), start)
        except BaseException:
            _remove_keys(obj)
            shape.write(obj, before)
            raise
        obj.data.update()

    def _path(self, obj):
        if self.filepath:
            return bpy.path.abspath(self.filepath)
        if not bpy.data.filepath:
            raise state.Refusal("Save the .blend file first, or name a file for the cache")
        return os.path.join(os.path.dirname(bpy.data.filepath), bpy.path.clean_name(obj.name) + ".pc2")

    @staticmethod
    def _add_keys(obj, frames):
        obj.shape_key_add(name="Basis", from_mix=False).data.foreach_set("co", frames[0].ravel())
        obj.data.vertices.foreach_set("co", frames[0].ravel())
        for i, frame in enumerate(frames[1:], start=1):
            obj.shape_key_add(name=f"Knead {i}", from_mix=False).data.foreach_set("co", frame.ravel())
        obj.active_shape_key_index = len(frames) - 1

    @staticmethod
    def _add_keyframes(obj, count, start):
        for i, key in enumerate(obj.data.shape_keys.key_blocks[1:], start=1):
            for at, value in ((i - 1, 0.0), (i, 1.0), (i + 1, 0.0)):
                if at < count:
                    key.value = value
                    key.keyframe_insert("value", frame=start + at)
        for curve in compat.curves(obj.data.shape_keys):
            for point in curve.keyframe_points:
                point.interpolation = "LINEAR"

    @staticmethod
    def _add_drivers(obj, count):
        obj[ALONG] = 1.0
        obj.id_properties_ui(ALONG).update(min=0.0, max=1.0, soft_min=0.0, soft_max=1.0, description="How far along the session")
        for i, key in enumerate(obj.data.shape_keys.key_blocks[1:], start=1):
            driver = key.driver_add("value").driver
            variable = driver.variables.new()
            variable.name = "along"
            variable.targets[0].id = obj
            variable.targets[0].data_path = f'["{ALONG}"]'
            driver.expression = f"max(0, 1 - abs(along * {count - 1} - {i}))"

    @staticmethod
    def _add_modifier(obj, path, start):
        modifier = obj.modifiers.get("Knead") or obj.modifiers.new("Knead", "MESH_CACHE")
        modifier.cache_format = "PC2"
        modifier.filepath = path
        modifier.frame_start = start
        bpy.ops.object.modifier_move_to_index(modifier=modifier.name, index=0)


def _remove_keys(obj):
    """Removes all shape keys and what moves them."""
    keys = obj.data.shape_keys
    if keys is None:
        return
    action = keys.animation_data and keys.animation_data.action
    obj.shape_key_clear()
    if action is not None and action.users == 0:
        bpy.data.actions.remove(action)
    if ALONG in obj:
        del obj[ALONG]


def register():
    bpy.utils.register_class(KNEAD_OT_bake)


def unregister():
    bpy.utils.unregister_class(KNEAD_OT_bake)
