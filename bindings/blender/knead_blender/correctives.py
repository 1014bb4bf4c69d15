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


class Rig:
    """The bones of an armature that deform a mesh, in the coordinates of the mesh."""

    def __init__(self, obj):
        armature = self.armature = _armature(obj)
        to_mesh = np.array(obj.matrix_world.inverted() @ armature.matrix_world)
        groups = {g.name: g.index for g in obj.vertex_groups}
        self.names = [b.name for b in armature.data.bones if b.use_deform and b.name in groups]
        if not self.names:
            raise state.Refusal("No vertex group has the name of a bone that deforms")
        number = {name: i for i, name in enumerate(self.names)}
        of_group = {groups[name]: i for name, i in number.items()}
        self.weights = np.zeros((len(obj.data.vertices), len(self.names)))
        for v in obj.data.vertices:
            for g in v.groups:
                if g.group in of_group:
                    self.weights[v.index, of_group[g.group]] = g.weight
        self.rest = np.array([to_mesh @ np.array(armature.data.bones[n].matrix_local) for n in self.names])
        self.pose = np.array([to_mesh @ np.array(armature.pose.bones[n].matrix) for n in self.names])
        self.parents = [self._parent(armature.data.bones[n], number) for n in self.names]

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
            parts.append(f"min(max(2*atan2({along},w{j})/{np.radians(angle):.6f},0),1)")
        driver.expression = "*".join(parts)


def _polygons(mesh):
    return [tuple(p.vertices) for p in mesh.polygons]


def _line(name, measures):
    volume = measures["volume_error"]
    text = "no volume" if volume is None else f"volume {100 * volume:+.3f} %"
    return f"{name}: {text}, {measures['crossings_new']} new crossings"


class KNEAD_OT_make_corrective(bpy.types.Operator):
    """Make a shape key for each joint that is turned now, driven by the joint, that gives the flesh its volume back"""

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
        rig = Rig(obj)
        keys = obj.data.shape_keys
        rest = shape.read_rest(obj).astype(np.float64)
        faces = _polygons(obj.data)
        made = knead.correctives(rest, faces, rig.weights, rig.rest, rig.pose, parents=rig.parents)
        if not made:
            raise state.Refusal("No joint turns by 5 degrees or more; pose the armature first")
        posed = knead.skin(rest, faces, rig.weights, rig.rest, rig.pose, parents=rig.parents)
        if keys is None:
            obj.shape_key_add(name="Basis", from_mix=False)
        for corrective in made:
            name = _PREFIX + " + ".join(rig.names[b] for b in corrective.bones)
            key = obj.data.shape_keys.key_blocks.get(name) or obj.shape_key_add(name=name, from_mix=False)
            key.data.foreach_set("co", (rest + corrective.offsets).astype(np.float32).ravel())
            rig.drive(key, corrective)
        obj.data.update()
        obj.update_tag()
        context.view_layer.update()
        lines = [_line("Before", posed.report["linear"]), _line("After", posed.report["flow"]), posed.problem]
        obj.knead.report = "\n".join(filter(None, lines))
        return len(made)


def register():
    bpy.utils.register_class(KNEAD_OT_make_corrective)


def unregister():
    bpy.utils.unregister_class(KNEAD_OT_make_corrective)
