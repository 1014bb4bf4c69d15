# SPDX-License-Identifier: GPL-3.0-or-later
"""knead.make_corrective: shape keys that give a posed mesh its volume back, driven by the armature's joints."""

import bpy
import numpy as np

from . import shape, state
from .native import knead

_PREFIX = "Knead "


def _armature(obj):
    found = [m for m in obj.modifiers if m.type == "ARMATURE" and m.object is not None and m.show_viewport]
    if len(found) != 1:
        raise state.Refusal("The mesh needs one armature modifier, with an armature")
    if found[0].use_deform_preserve_volume:
        raise state.Refusal("Switch off Preserve Volume of the armature modifier: correctives go with linear blending")
    if found[0].use_bone_envelopes or not found[0].use_vertex_groups:
        raise state.Refusal("The armature modifier must use vertex groups, and no bone envelopes")
    return found[0].object


class Worn:
    """A mesh that hangs on the armature: vertices at rest in the coordinates of the active mesh, and faces."""

    def __init__(self, obj, active):
        self.obj = obj
        self.own = shape.read_rest(obj).astype(np.float64)
        self.to_active = np.array(active.matrix_world.inverted() @ obj.matrix_world) if obj != active else np.eye(4)
        self.rest = self.own @ self.to_active[:3, :3].T + self.to_active[:3, 3]
        self.faces = [tuple(p.vertices) for p in obj.data.polygons]

    def write(self, name, offsets):
        """Makes or changes a shape key. Offsets are in the coordinates of the active mesh."""
        if self.obj.data.shape_keys is None:
            self.obj.shape_key_add(name="Basis", from_mix=False)
        key = self.obj.data.shape_keys.key_blocks.get(name) or self.obj.shape_key_add(name=name, from_mix=False)
        key.data.foreach_set("co", (self.own + offsets @ np.linalg.inv(self.to_active[:3, :3]).T).astype(np.float32).ravel())
        return key


def _clothes(context, active):
    """Returns the other selected meshes that hang on the armature of the active one."""
    armature, others = _armature(active), []
    for obj in context.selected_objects:
        if obj == active or obj.type != "MESH" or not any(m.type == "ARMATURE" for m in obj.modifiers):
            continue
        if _armature(obj) == armature:
            others.append(obj)
    return others


class Rig:
    """The bones of an armature that deform meshes, in the coordinates of the first, which is the active one."""

    def __init__(self, objects):
        obj = objects[0]
        armature = self.armature = _armature(obj)
        to_mesh = np.array(obj.matrix_world.inverted() @ armature.matrix_world)
        used = {g.name for each in objects for g in each.vertex_groups}
        self.names = [b.name for b in armature.data.bones if b.use_deform and b.name in used]
        if not self.names:
            raise state.Refusal("No vertex group has the name of a bone that deforms")
        number = {name: i for i, name in enumerate(self.names)}
        self.weights = np.concatenate([self._weights(each, number) for each in objects])
        self.rest = np.array([to_mesh @ np.array(armature.data.bones[n].matrix_local) for n in self.names])
        self.pose = np.array([to_mesh @ np.array(armature.pose.bones[n].matrix) for n in self.names])
        self.parents = [self._parent(armature.data.bones[n], number) for n in self.names]

    @staticmethod
    def _weights(obj, number):
        of_group = {g.index: number[g.name] for g in obj.vertex_groups if g.name in number}
        weights = np.zeros((len(obj.data.vertices), len(number)))
        for v in obj.data.vertices:
            for g in v.groups:
                if g.group in of_group:
                    weights[v.index, of_group[g.group]] = g.weight
        return weights

    @staticmethod
    def _parent(bone, number):
        while bone.parent is not None:
            bone = bone.parent
            if bone.name in number:
                return number[bone.name]
        return -1

    def drive(self, key, corrective):
        """Drives a shape key by how far the bones turn about their axes."""
        key.driver_remove("value")
        driver = key.driver_add("value").driver
        driver.type = "SCRIPTED"
        parts = []
        for j, (bone, axis, angle) in enumerate(zip(corrective.bones, corrective.axes, corrective.angles_deg)):
            turn = self.rest[bone][:3, :3] / np.linalg.norm(self.rest[bone][:3, :3], axis=0)
            own = turn.T @ axis  # in the bone's coordinates at rest
            for part in "WXYZ":
                variable = driver.variables.new()
                variable.name = f"{part.lower()}{j}"
                variable.type = "TRANSFORMS"
                target = variable.targets[0]
                target.id = self.armature
                target.bone_target = self.names[bone]
                target.transform_space = "LOCAL_SPACE"
                target.rotation_mode = "QUATERNION"
                target.transform_type = f"ROT_{part}"
            along = f"({own[0]:.6f}*x{j}+({own[1]:.6f})*y{j}+({own[2]:.6f})*z{j})"
            parts.append(f"min(max(2*atan2({along},w{j})/{np.radians(angle):.6f},0),1)**2")  # as knead.Corrective
        driver.expression = "*".join(parts)


def _line(name, measures, volume, count):
    """`volume` is of the active mesh, crossings are of all meshes together."""
    text = "no volume" if volume is None else f"volume {100 * volume:+.3f} %"
    return f"{name}: {text}, {measures['crossings_new']} new crossings" + (f" in {count} meshes" if count > 1 else "")


def _volume_error(before, after, faces):
    """Returns by which fraction the volume has changed; None for a mesh that is not closed."""
    first, last = (knead.check(points, faces)["volume"] for points in (before, after))
    return last / first - 1 if first and last else None


class KNEAD_OT_make_corrective(bpy.types.Operator):
    """Make a shape key for each joint that is turned now, driven by the joint, that gives the flesh its volume back.
    Other selected meshes on the same armature, such as clothes, go along in the same flow"""

    bl_idname = "knead.make_corrective"
    bl_label = "Make Corrective"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type == "MESH"

    def execute(self, context):
        try:
            count = self.work(context, context.object)
        except (state.Refusal, shape.Refusal, ValueError, RuntimeError) as error:
            self.report({"ERROR"}, str(error))
            return {"CANCELLED"}
        self.report({"INFO"}, f"{count} corrective shape keys")
        return {"FINISHED"}

    def work(self, context, obj):
        worn = [Worn(each, obj) for each in (obj, *_clothes(context, obj))]
        rig = Rig([each.obj for each in worn])
        rest = np.concatenate([each.rest for each in worn])
        ends = np.cumsum([len(each.rest) for each in worn])
        starts = [0, *ends[:-1]]
        faces = [tuple(int(start) + v for v in face) for each, start in zip(worn, starts) for face in each.faces]
        made = knead.correctives(rest, faces, rig.weights, rig.rest, rig.pose, parents=rig.parents)
        if not made:
            raise state.Refusal("No joint turns by 5 degrees or more; pose the armature first")
        posed = knead.skin(rest, faces, rig.weights, rig.rest, rig.pose, parents=rig.parents)
        for corrective in made:
            name = _PREFIX + " + ".join(rig.names[b] for b in corrective.bones)
            for each, start, end in zip(worn, starts, ends):
                rig.drive(each.write(name, corrective.offsets[start:end]), corrective)
        for each in worn:
            each.obj.data.update()
            each.obj.update_tag()
        context.view_layer.update()
        own = slice(0, len(worn[0].rest))
        lines = [
            _line(name, posed.report[way], _volume_error(rest[own], points[own], worn[0].faces), len(worn))
            for name, way, points in (("Before", "linear", posed.linear), ("After", "flow", posed.vertices))
        ]
        obj.knead.report = "\n".join(filter(None, [*lines, posed.problem]))
        return len(made)


def register():
    bpy.utils.register_class(KNEAD_OT_make_corrective)


def unregister():
    bpy.utils.unregister_class(KNEAD_OT_make_corrective)
