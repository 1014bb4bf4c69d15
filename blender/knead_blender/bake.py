"""knead.bake: the motion of a session as shape keys, or as a PC2 file with the modifier Mesh Cache."""

import os

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty

from . import rebuild, shape, state
from .native import knead
from .operators import OfSession


def frames_of(obj, count):
    """Returns the coordinates at `count` moments, evenly spaced in time from the base to the end of the session."""
    session = state.parse(obj.knead.session)
    rebuild.check_session(session)
    base = shape.read_base(obj.data)
    if base is None:
        raise state.Refusal("The base positions are gone, or the mesh has other vertices now")
    frame = state.frame_of(obj.data)
    entered = frame.enter(base)
    return [frame.leave(moved, entered, base) for moved in knead.frames(entered, session, count, shape.faces(obj.data))]


class KNEAD_OT_bake(OfSession, bpy.types.Operator):
    """Make an animation of the session"""

    bl_idname = "knead.bake"
    bl_label = "Bake Animation"
    frames: IntProperty(name="Frames", default=24, min=2, max=1000)
    to: EnumProperty(
        name="To",
        items=[
            ("SHAPE_KEYS", "Shape Keys", "A shape key for each frame, with keyframes"),
            ("MESH_CACHE", "Mesh Cache", "A PC2 file and the modifier Mesh Cache"),
        ],
    )
    filepath: StringProperty(name="File", subtype="FILE_PATH", description="The PC2 file; empty: beside the .blend file")

    def invoke(self, context, event):
        return context.window_manager.invoke_props_dialog(self)

    def work(self, context, obj):
        if self.to == "SHAPE_KEYS" and obj.data.shape_keys is not None:
            raise state.Refusal("The mesh has shape keys; bake to a mesh cache, or remove them first")
        path = self._path(obj) if self.to == "MESH_CACHE" else None
        frames = frames_of(obj, self.frames)
        start = context.scene.frame_start
        if path is None:
            self._add_keys(obj, frames, start)
        else:
            knead.write_frames(path, frames)
            self._add_modifier(obj, path, start)
        context.scene.frame_end = max(context.scene.frame_end, start + len(frames) - 1)

    def _path(self, obj):
        if self.filepath:
            return bpy.path.abspath(self.filepath)
        if not bpy.data.filepath:
            raise state.Refusal("Save the .blend file first, or name a file for the cache")
        return os.path.join(os.path.dirname(bpy.data.filepath), bpy.path.clean_name(obj.name) + ".pc2")

    @staticmethod
    def _add_keys(obj, frames, start):
        obj.shape_key_add(name="Basis", from_mix=False).data.foreach_set("co", frames[0].ravel())
        obj.data.vertices.foreach_set("co", frames[0].ravel())
        for i, frame in enumerate(frames[1:], start=1):
            key = obj.shape_key_add(name=f"Knead {i}", from_mix=False)
            key.data.foreach_set("co", frame.ravel())
            for at, value in ((i - 1, 0.0), (i, 1.0), (i + 1, 0.0)):
                if at < len(frames):
                    key.value = value
                    key.keyframe_insert("value", frame=start + at)
        for curve in obj.data.shape_keys.animation_data.action.fcurves:
            for point in curve.keyframe_points:
                point.interpolation = "LINEAR"
        obj.data.update()

    @staticmethod
    def _add_modifier(obj, path, start):
        modifier = obj.modifiers.get("Knead") or obj.modifiers.new("Knead", "MESH_CACHE")
        modifier.cache_format = "PC2"
        modifier.filepath = path
        modifier.frame_start = start
        bpy.ops.object.modifier_move_to_index(modifier=modifier.name, index=0)


def register():
    bpy.utils.register_class(KNEAD_OT_bake)


def unregister():
    bpy.utils.unregister_class(KNEAD_OT_bake)
