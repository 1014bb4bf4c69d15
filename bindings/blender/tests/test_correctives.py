"""Run inside Blender, with the add-on installed: corrective shape keys of a bent arm."""

import os
import sys

import bpy
import numpy as np
from mathutils import Matrix

sys.path.insert(0, os.path.dirname(__file__))
from support import Case, refuses, run


def volume(vertices, faces):
    t = np.array([(f[0], f[i], f[i + 1]) for f in faces for i in range(1, len(f) - 1)])
    return np.einsum("ij,ij->", vertices[t[:, 0]], np.cross(vertices[t[:, 1]], vertices[t[:, 2]])) / 6


class Correctives(Case):
    def arm(self):
        """A cylinder along x with an armature of two bones, the second from the origin on."""
        # Rings along the cylinder.
        turns, rings = 24, 49
        angle = 2 * np.pi * np.arange(turns) / turns
        x = np.repeat(np.linspace(-3, 3, rings), turns)
        v = np.stack([x, np.tile(0.5 * np.cos(angle), rings), np.tile(0.5 * np.sin(angle), rings)], axis=1)
        faces = [[r * turns + k, r * turns + (k + 1) % turns, (r + 1) * turns + (k + 1) % turns, (r + 1) * turns + k] for r in range(rings - 1) for k in range(turns)]
        faces += [list(range(turns))[::-1], list(range((rings - 1) * turns, rings * turns))]
        mesh = bpy.data.meshes.new("arm")
        mesh.from_pydata(v.tolist(), [], faces)
        obj = bpy.data.objects.new("arm", mesh)
        bpy.context.collection.objects.link(obj)
        data = bpy.data.armatures.new("rig")
        rig = bpy.data.objects.new("rig", data)
        bpy.context.collection.objects.link(rig)
        bpy.context.view_layer.objects.active = rig
        bpy.ops.object.mode_set(mode="EDIT")
        upper = data.edit_bones.new("upper")
        upper.head, upper.tail = (-3, 0, 0), (0, 0, 0)
        lower = data.edit_bones.new("lower")
        lower.head, lower.tail = (0, 0, 0), (3, 0, 0)
        lower.parent = upper
        bpy.ops.object.mode_set(mode="OBJECT")
        bpy.context.view_layer.objects.active = obj
        weight = np.clip(0.5 + v[:, 0] / 1.2, 0, 1)
        for name, values in (("upper", 1 - weight), ("lower", weight)):
            group = obj.vertex_groups.new(name=name)
            for i, w in enumerate(values):
                group.add([i], float(w), "REPLACE")
        obj.modifiers.new("Armature", "ARMATURE").object = rig
        return obj, rig, faces

    def bend(self, rig, degrees):
        bone = rig.pose.bones["lower"]
        bone.rotation_mode = "QUATERNION"
        rest = rig.data.bones["lower"].matrix_local.to_3x3()
        turn = rest.inverted() @ Matrix.Rotation(np.radians(degrees), 3, "Z") @ rest
        bone.rotation_quaternion = turn.to_quaternion()
        bpy.context.view_layer.update()

    def shown(self, obj):
        evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
        flat = np.empty(3 * len(evaluated.data.vertices), np.float32)
        evaluated.data.vertices.foreach_get("co", flat)
        return flat.reshape(-1, 3).astype(float)

    def test_the_volume_comes_back_and_follows_the_joint(self):
        obj, rig, faces = self.arm()
        rest = volume(self.shown(obj), faces)
        self.bend(rig, 90)
        before = volume(self.shown(obj), faces) / rest - 1
        self.assertLess(before, -5e-3)
        self.assertEqual(bpy.ops.knead.make_corrective(), {"FINISHED"})
        key = obj.data.shape_keys.key_blocks["Knead lower"]
        self.assertAlmostEqual(key.value, 1, places=4)
        after = volume(self.shown(obj), faces) / rest - 1
        self.assertLess(abs(after), abs(before) / 5)
        self.assertIn("After: volume", obj.knead.report)
        self.bend(rig, 45)
        self.assertAlmostEqual(key.value, 0.25, places=4)
        self.bend(rig, 0)
        self.assertAlmostEqual(key.value, 0, places=4)
        self.bend(rig, -30)
        self.assertAlmostEqual(key.value, 0, places=4)

    def sleeve(self, arm, rig):
        """An open tube about the arm, scaled and moved as an object, with the arm's weights."""
        rings, turns = 33, 24
        angle = 2 * np.pi * (np.arange(turns) + 0.5) / turns
        x = np.repeat(np.linspace(-2, 2, rings), turns)
        v = np.stack([x, np.tile(0.56 * np.cos(angle), rings), np.tile(0.56 * np.sin(angle), rings)], axis=1)
        faces = [[r * turns + k, r * turns + (k + 1) % turns, (r + 1) * turns + (k + 1) % turns, (r + 1) * turns + k] for r in range(rings - 1) for k in range(turns)]
        mesh = bpy.data.meshes.new("sleeve")
        mesh.from_pydata((v / 2 - [1, 0, 0]).tolist(), [], faces)
        obj = bpy.data.objects.new("sleeve", mesh)
        obj.scale, obj.location = (2, 2, 2), (2, 0, 0)
        bpy.context.collection.objects.link(obj)
        for name, values in (("upper", np.clip(0.5 - v[:, 0] / 1.2, 0, 1)), ("lower", np.clip(0.5 + v[:, 0] / 1.2, 0, 1))):
            group = obj.vertex_groups.new(name=name)
            for i, w in enumerate(values):
                group.add([i], float(w), "REPLACE")
        obj.modifiers.new("Armature", "ARMATURE").object = rig
        bpy.context.view_layer.update()
        return obj, faces

    def test_clothes_go_along_and_nothing_comes_through(self):
        from knead_blender.native import knead

        obj, rig, faces = self.arm()
        sleeve, sleeve_faces = self.sleeve(obj, rig)
        both = faces + [[v + len(obj.data.vertices) for v in face] for face in sleeve_faces]

        def crossings():
            world = np.array(sleeve.matrix_world)
            return len(knead.crossings(np.concatenate([self.shown(obj), self.shown(sleeve) @ world[:3, :3].T + world[:3, 3]]), both))

        self.assertEqual(crossings(), 0)
        self.bend(rig, 110)
        self.assertGreater(crossings(), 10)
        for each in bpy.context.selected_objects:
            each.select_set(False)
        for each in (sleeve, obj):
            each.select_set(True)
        bpy.context.view_layer.objects.active = obj
        self.assertEqual(bpy.ops.knead.make_corrective(), {"FINISHED"})
        self.assertEqual([k.name for k in sleeve.data.shape_keys.key_blocks], ["Basis", "Knead lower"])
        bpy.context.view_layer.update()
        self.assertAlmostEqual(sleeve.data.shape_keys.key_blocks[1].value, 1, places=4)
        self.assertEqual(crossings(), 0)
        self.assertIn("0 new crossings in 2 meshes", obj.knead.report)

    def test_refusals_change_nothing(self):
        obj, rig, _ = self.arm()
        refuses(self, bpy.ops.knead.make_corrective, "No joint turns")
        self.bend(rig, 60)
        obj.modifiers[0].use_deform_preserve_volume = True
        refuses(self, bpy.ops.knead.make_corrective, "Preserve Volume")
        obj.modifiers.clear()
        refuses(self, bpy.ops.knead.make_corrective, "armature modifier")
        self.assertIsNone(obj.data.shape_keys)


run(Correctives)
