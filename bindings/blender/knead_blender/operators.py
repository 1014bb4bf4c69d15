# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators on the session of the active object."""

import json
import os

import bpy
import numpy as np
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty
from bpy_extras.io_utils import ExportHelper, ImportHelper

from . import rebuild, shape, shown, stamps, state
from .background import Background
from .native import knead

_ERRORS = (state.Refusal, ValueError, RuntimeError, OSError)


class Plain:
    """An operator that ends with one sentence where it cannot do its work, and changes nothing then."""

    bl_options = {"REGISTER", "UNDO"}

    def execute(self, context):
        try:
            state.require_mesh(context.object)
            self.work(context, context.object)
        except _ERRORS as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        return {"FINISHED"}


class OfSession(Plain):
    """An operator that needs a session."""

    @classmethod
    def poll(cls, context):
        obj = context.object
        return obj is not None and obj.type == "MESH" and bool(obj.knead.session)


class KNEAD_OT_apply_session(Plain, ImportHelper, bpy.types.Operator):
    """Apply the strokes of a .knead file to the active mesh, after those that it has"""

    bl_idname = "knead.apply_session"
    bl_label = "Apply Session"
    filename_ext = ".knead"
    filter_glob: StringProperty(default="*.knead", options={"HIDDEN"})
    relative_tolerance: FloatProperty(name="Tolerance", default=1e-5, min=1e-12, max=0.1, precision=8)
    to: EnumProperty(
        name="To",
        items=[("MESH", "Mesh", "The mesh, or its active shape key"), ("SHAPE_KEY", "Shape Key", "A new shape key")],
    )
    space: EnumProperty(
        name="Space",
        items=[("LOCAL", "Object", "The strokes are in the object's space"), ("WORLD", "World", "In the world's space")],
    )

    def work(self, context, obj):
        session = knead.Session.read(self.filepath)
        tolerance = round(self.relative_tolerance, 12)  # the property holds a float: 1e-5 is 9.99999975e-06
        if self.to == "SHAPE_KEY":
            self._add_key(obj, session, tolerance)
            return
        append(self, obj, _with_absolute_stamps(session), self.space, tolerance)

    def _add_key(self, obj, session, tolerance):
        before, is_posed = shown.read(obj), shown.is_posed(obj)
        frame = state.frame_for(obj, self.space)
        coordinates = rebuild.compute(before, shape.faces(obj.data), session, frame, tolerance)
        active, had_keys = obj.active_shape_key_index, obj.data.shape_keys is not None
        key = shape.add_key(obj, bpy.path.display_name_from_filepath(self.filepath))
        try:
            key.data.foreach_set("co", (shown.Link(obj).follow(coordinates) if is_posed else coordinates).ravel())
        except state.Refusal:
            obj.shape_key_remove(key) if had_keys else obj.shape_key_clear()
            raise
        finally:
            obj.active_shape_key_index = active
        obj.data.update()


def _with_absolute_stamps(session):
    """Returns the session with whole paths of the stamps' files, because a text has no folder."""
    folder = os.path.dirname(os.path.abspath(session.path or "."))
    changed = [s.replace(mesh=os.path.join(folder, s.mesh)) if s.tool == "stamp" else s for s in session]
    result = knead.Session(changed, session.mesh, session.note)
    return result


class KNEAD_OT_session_import(Plain, ImportHelper, bpy.types.Operator):
    """Replace the object's session by a .knead file, from its base positions"""

    bl_idname = "knead.session_import"
    bl_label = "Import Session"
    filename_ext = ".knead"
    filter_glob: StringProperty(default="*.knead", options={"HIDDEN"})

    def work(self, context, obj):
        session = _with_absolute_stamps(knead.Session.read(self.filepath))
        _replace(obj, session)


class KNEAD_OT_session_export(OfSession, ExportHelper, bpy.types.Operator):
    """Write the object's session as a .knead file"""

    bl_idname = "knead.session_export"
    bl_label = "Export Session"
    bl_options = {"REGISTER"}
    filename_ext = ".knead"
    filter_glob: StringProperty(default="*.knead", options={"HIDDEN"})

    def work(self, context, obj):
        session = state.parse(obj.knead.session)
        (stamps.settled(session, os.path.dirname(os.path.abspath(self.filepath))) or session).write(self.filepath)


class KNEAD_OT_session_clear(OfSession, bpy.types.Operator):
    """Forget the session; the mesh stays as it is, or goes back to its base positions"""

    bl_idname = "knead.session_clear"
    bl_label = "Clear Session"
    restore: BoolProperty(name="Restore the Mesh", description="Go back to the base positions")

    def work(self, context, obj):
        if self.restore:
            state.require_own_key(obj)
            shape.write(obj, state.to_edit(obj, _require_base(obj)))
        shape.remove_base(obj.data)
        obj.data.knead.session = ""
        obj.data.knead.result = obj.data.knead.seen = ""
        obj.data.knead.is_posed = False


def _require_base(obj):
    base = shape.read_base(obj.data)
    if base is None:
        raise state.Refusal("The base positions are gone, or the mesh has other vertices now; clear the session")
    return base


def _replace(obj, session, discard=False):
    """Makes the mesh what another session makes of its base."""
    if obj.knead.session:
        state.require_own_key(obj)
        if not discard and state.changed_elsewhere(obj):
            raise state.Refusal("The mesh was changed elsewhere, which a rebuild would lose; clear the session to keep it")
        base, frame = _require_base(obj), state.frame_of(obj.data)
    else:
        base, frame = shown.read(obj), shape.Frame()
    coordinates = state.to_edit(obj, rebuild.compute(base, shape.faces(obj.data), session, frame))
    if not obj.knead.session:
        state.begin(obj)
    state.keep(obj, session, coordinates)


class KNEAD_OT_session_rebuild(Background, OfSession, bpy.types.Operator):
    """Compute the mesh anew from its base positions; Esc stops"""

    bl_idname = "knead.session_rebuild"
    bl_label = "Rebuild"
    discard: BoolProperty(name="Discard Other Changes", description="Lose what other tools changed since the last stroke")

    def work(self, context, obj):
        _replace(obj, state.parse(obj.knead.session), self.discard)

    def invoke(self, context, event):
        obj = context.object
        try:
            state.require_mesh(obj)
            state.require_own_key(obj)
            if not self.discard and state.changed_elsewhere(obj):
                raise state.Refusal("The mesh was changed elsewhere, which a rebuild would lose; clear the session to keep it")
            session, base, frame = state.parse(obj.knead.session), _require_base(obj), state.frame_of(obj.data)
            rebuild.check_session(session)
            faces = shape.faces(obj.data)
        except _ERRORS as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self._session = session
        return self.start(context, obj, lambda progress: rebuild.compute(base, faces, session, frame, progress=progress))

    def finish(self, context, obj, coordinates):
        state.keep(obj, self._session, state.to_edit(obj, coordinates))


class OfStroke(OfSession):
    """Changes one stroke of the session, and rebuilds."""

    index: IntProperty(name="Stroke", min=0)

    def work(self, context, obj):
        session = state.parse(obj.knead.session)
        if self.index >= len(session):
            raise state.Refusal(f"The session has {len(session)} strokes, no number {self.index + 1}")
        try:
            self.change(session)
            _replace(obj, session)
        except _ERRORS:
            state._list_strokes(obj.data.knead)
            raise


class KNEAD_OT_stroke_off(OfStroke, bpy.types.Operator):
    """Switch a stroke off or on"""

    bl_idname = "knead.stroke_off"
    bl_label = "Switch Stroke"
    off: BoolProperty(name="Off")

    def change(self, session):
        session[self.index] = session[self.index].replace(off=True if self.off else None)


class KNEAD_OT_stroke_move(OfStroke, bpy.types.Operator):
    """Move a stroke to another place of the session"""

    bl_idname = "knead.stroke_move"
    bl_label = "Move Stroke"
    to: IntProperty(name="To", min=0)

    def change(self, session):
        if self.to >= len(session):
            raise state.Refusal("The stroke is the last one")
        stroke = session[self.index]
        del session[self.index]
        session.insert(self.to, stroke)


class KNEAD_OT_stroke_remove(OfStroke, bpy.types.Operator):
    """Remove a stroke from the session"""

    bl_idname = "knead.stroke_remove"
    bl_label = "Remove Stroke"

    def change(self, session):
        del session[self.index]


class KNEAD_OT_stroke_edit(OfStroke, bpy.types.Operator):
    """Edit the keys of a stroke, as a line of a session file"""

    bl_idname = "knead.stroke_edit"
    bl_label = "Edit Stroke"
    line: StringProperty(name="Keys", description="The stroke as JSON, as docs/session.md describes it")

    def invoke(self, context, event):
        session = state.parse(context.object.knead.session)
        if self.index >= len(session):
            return {"CANCELLED"}
        self.line = json.dumps(session[self.index].to_dict())
        return context.window_manager.invoke_props_dialog(self, width=800)

    def change(self, session):
        session[self.index] = knead.stroke(json.loads(self.line))


class KNEAD_OT_add_mask(Plain, bpy.types.Operator):
    """Keep a vertex group, or what the sculpt mask and hiding cover, from all strokes after this"""

    bl_idname = "knead.add_mask"
    bl_label = "Mask"
    group: StringProperty(name="Vertex Group", description="Empty: the sculpt mask")
    width: FloatProperty(name="Width", description="How far from what stays the mesh is free again", default=0.1, min=1e-6)

    def work(self, context, obj):
        group = obj.vertex_groups.get(self.group)
        if self.group and group is None:
            raise state.Refusal(f"The object has no vertex group {self.group}")
        mask = rebuild.mask_stroke(obj, self.width, group)
        append(self, obj, [mask])


class KNEAD_OT_remove_mask(OfSession, bpy.types.Operator):
    """End the mask for all strokes after this"""

    bl_idname = "knead.remove_mask"
    bl_label = "End Mask"

    def work(self, context, obj):
        append(self, obj, [knead.stroke({"mask": None})])


class KNEAD_OT_fit(bpy.types.Operator):
    """Fit the other selected mesh to the active one: a session that takes its surface there"""

    bl_idname = "knead.fit"
    bl_label = "Fit to Active Object"
    bl_options = {"REGISTER", "UNDO"}
    volume: EnumProperty(
        name="Volume",
        items=[
            ("keep", "Keep", "The volume stays"),
            ("free", "Free", "The body grows and shrinks on purpose where the other one asks for it"),
        ],
    )

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == "MESH" and len(_others(context)) == 1

    def execute(self, context):
        (source,) = _others(context)
        try:
            state.require_mesh(context.object)
            state.require_mesh(source)
            fit = self.fitted(source, context.object)
            append(self, source, fit.session)
        except _ERRORS as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        distance = f"{100 * fit.report['distance_after']['mean']:.2g}% of its size from it"
        if fit.problem:
            self.report({"WARNING"}, f"{source.name} is {distance}; {fit.problem}")
        else:
            self.report({"INFO"}, f"{source.name} is {distance}")
        return {"FINISHED"}

    def fitted(self, source, target):
        """A fit in the space of the source."""
        there = shape.Frame((source.matrix_world.inverted() @ target.matrix_world))
        places = there.enter(shown.read(target))
        return knead.fit(
            (shown.read(source), shape.faces(source.data)), (places, shape.faces(target.data)), volume=self.volume
        )


class KNEAD_OT_bend_along(Plain, bpy.types.Operator):
    """Bend the active mesh along the other selected object, a curve: its longest axis becomes the curve"""

    bl_idname = "knead.bend_along"
    bl_label = "Bend Along Curve"
    reverse: BoolProperty(name="Reverse", description="From the end of the curve to its start")
    fit: BoolProperty(name="Fit Length", description="Stretch the mesh to the length of the curve; it grows thinner by the square root")
    fixed: EnumProperty(
        name="Anchor",
        items=[
            ("start", "Start", "The start of the mesh goes to the start of the curve"),
            ("middle", "Middle", "The middle goes to the middle"),
            ("end", "End", "The end goes to the end"),
        ],
    )
    twist_deg: FloatProperty(name="Twist", description="Degrees by which the end turns against the start")
    keep: EnumProperty(
        name="Keep",
        items=[("volume", "Volume", "The volume stays at every place"), ("thickness", "Thickness", "Distances from the curve stay")],
    )

    def work(self, context, obj):
        curves = [each for each in context.selected_objects if each.type == "CURVE"]
        if len(curves) != 1:
            raise state.Refusal("Select one curve, and then the mesh that is bent along it")
        to_mesh = np.array(obj.matrix_world.inverted_safe() @ curves[0].matrix_world)
        points = _line_of(curves[0].data) @ to_mesh[:3, :3].T + to_mesh[:3, 3]
        numbers = {"twist_deg": self.twist_deg} if self.twist_deg else {}
        line = {"tool": "curve", "to": (points[::-1] if self.reverse else points).tolist(), "fixed": self.fixed, **numbers}
        append(self, obj, [knead.stroke({**line, "length": "fit" if self.fit else "keep", "keep": self.keep})])


def _line_of(curve):
    """Returns the points of the one open line of a curve, without its bevel: (n, 3)."""
    if len(curve.splines) != 1 or curve.splines[0].use_cyclic_u:
        found = "a closed one" if len(curve.splines) == 1 else f"{len(curve.splines)} lines"
        raise state.Refusal(f"The curve must be one open line; this has {found}")
    bare = curve.copy()
    bare.bevel_depth, bare.extrude, bare.bevel_object = 0, 0, None
    holder = bpy.data.objects.new("line", bare)
    try:
        points = np.array([v.co for v in holder.to_mesh().vertices], float)
    finally:
        holder.to_mesh_clear()
        bpy.data.objects.remove(holder)
        bpy.data.curves.remove(bare)
    return points


class KNEAD_OT_take_along(OfSession, bpy.types.Operator):
    """Move the other selected meshes, such as clothes, by the session of the active one: each gets a shape key"""

    bl_idname = "knead.take_along"
    bl_label = "Take Selected Along"

    def work(self, context, obj):
        others = _others(context)
        if not others:
            raise state.Refusal("Select what moves along, and then the mesh with the session")
        session, frame = state.parse(obj.knead.session), state.frame_of(obj.data)
        rebuild.check_session(session)
        flow = session.resolve(frame.enter(_require_base(obj)), shape.faces(obj.data))
        own = np.eye(4) if frame.matrix is None else frame.matrix
        made = []
        for other in others:
            state.require_mesh(other)
            there = shape.Frame(own @ np.array(obj.matrix_world.inverted() @ other.matrix_world))
            before = shape.read_rest(other)
            made.append((other, there.leave(knead.deform(there.enter(before), flow), there.enter(before), before)))
        name = f"Knead along {obj.name}"
        for other, places in made:
            keys = other.data.shape_keys
            key = keys.key_blocks.get(name) if keys is not None else None
            if key is None:
                active, had_keys = other.active_shape_key_index, keys is not None
                key = shape.add_key(other, name)
                if had_keys:
                    other.active_shape_key_index = active
            key.data.foreach_set("co", places.ravel())
            other.data.update()
            other.data.update_tag()


def _others(context):
    """The selected meshes besides the active one."""
    return [obj for obj in context.selected_objects if obj.type == "MESH" and obj != context.object]


def append(operator, obj, strokes, space="LOCAL", tolerance=1e-5):
    """Applies strokes after those of the object's session. Where that fails, nothing has changed."""
    shown.require_seen(obj)
    extends = state.extends(obj)
    if extends:
        state.require_space(obj.data, space)
    whole = state.parse(obj.knead.session if extends else "")
    whole.extend(strokes)
    frame = state.frame_of(obj.data) if extends else state.frame_for(obj, space)
    base = shape.read_base(obj.data) if extends else shown.read(obj)
    coordinates = shown.follow(obj, rebuild.compute(base, shape.faces(obj.data), whole, frame, tolerance))
    if not extends:
        if obj.knead.session:
            operator.report({"WARNING"}, "The mesh was changed elsewhere: its session begins anew")
        state.begin(obj, space)
    state.keep(obj, whole, coordinates)


_CLASSES = (
    KNEAD_OT_apply_session,
    KNEAD_OT_session_import,
    KNEAD_OT_take_along,
    KNEAD_OT_session_export,
    KNEAD_OT_session_clear,
    KNEAD_OT_session_rebuild,
    KNEAD_OT_stroke_off,
    KNEAD_OT_stroke_move,
    KNEAD_OT_stroke_remove,
    KNEAD_OT_stroke_edit,
    KNEAD_OT_add_mask,
    KNEAD_OT_remove_mask,
    KNEAD_OT_fit,
    KNEAD_OT_bend_along,
)


def register():
    for cls in _CLASSES:
        bpy.utils.register_class(cls)


def unregister():
    for cls in reversed(_CLASSES):
        bpy.utils.unregister_class(cls)
