"""Run inside Blender, with the add-on installed: meshes that are shown elsewhere than their own vertices lie."""

import json
import os
import sys

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(__file__))
from support import Case, key_values, make_hand, refuses, run, session_file


def pose(obj, degrees=50):
    """Gives the hand a rig of one bone, from the middle of the fingers on, and turns that."""
    rig = bpy.data.objects.new("rig", bpy.data.armatures.new("rig"))
    bpy.context.collection.objects.link(rig)
    bpy.context.view_layer.objects.active = rig
    bpy.ops.object.mode_set(mode="EDIT")
    bone = rig.data.edit_bones.new("fingers")
    bone.head, bone.tail = (0, 0.3, 0), (0, 0.9, 0)
    bpy.ops.object.mode_set(mode="OBJECT")
    bpy.context.view_layer.objects.active = obj
    group = obj.vertex_groups.new(name="fingers")
    for vertex in obj.data.vertices:
        group.add([vertex.index], float(np.clip((vertex.co.y - 0.2) / 0.2, 0, 1)), "REPLACE")
    obj.modifiers.new("Armature", "ARMATURE").object = rig
    turn(rig, degrees)
    return rig


def turn(rig, degrees):
    bone = rig.pose.bones["fingers"]
    bone.rotation_mode = "XYZ"
    bone.rotation_euler = (np.radians(degrees), 0, 0)
    bpy.context.view_layer.update()


class Shown(Case):
    def seen(self, obj):
        mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        flat = np.empty(3 * len(mesh.vertices), np.float32)
        mesh.vertices.foreach_get("co", flat)
        return flat.reshape(-1, 3)

    def size(self, obj):
        return float(np.linalg.norm(np.ptp(self.seen(obj), axis=0)))

    def tip(self, seen, before):
        return [float(x) for x in seen[before[:, 1].argmax()]]

    def turned(self, obj, seen):
        """Applies a turn at the tip that is seen; returns what the library makes of the places that were seen."""
        from knead_blender.native import knead

        stroke = {"center": self.tip(seen, self.vertices(obj)), "axis": (1, 0, 0), "angle_deg": 25, "inner": 0.1, "outer": 0.35}
        self.assertEqual(bpy.ops.knead.rotate(**stroke), {"FINISHED"})
        strokes = [json.loads(line) for line in obj.knead.session.splitlines()[1:]]
        base = self.base(obj).astype(float)
        return knead.deform(base, knead.Session([knead.stroke(s) for s in strokes]), self.faces(obj))

    def near(self, obj, wanted, seen):
        self.assertGreater(np.abs(wanted - seen).max(), 0.02)  # the stroke does something
        self.assertLess(np.abs(self.seen(obj) - wanted).max(), 1e-5 * self.size(obj))

    def test_a_stroke_moves_the_posed_mesh_that_is_shown(self):
        obj = make_hand()
        own, rig = self.vertices(obj), pose(obj)
        seen = self.seen(obj)
        self.assertGreater(np.abs(seen - own).max(), 0.2)
        wanted = self.turned(obj, seen)
        self.near(obj, wanted, seen)
        self.same(self.vertices(obj), own)
        self.same(self.base(obj), seen)
        self.assertEqual([k.name for k in obj.data.shape_keys.key_blocks], ["Basis", "Knead"])
        still = (wanted == seen).all(axis=1)
        self.assertGreater(still.mean(), 0.5)
        self.same(key_values(obj, 1)[still], own[still])
        seen = self.seen(obj)
        self.near(obj, self.turned(obj, seen), seen)  # the session goes on
        self.assertEqual(len(obj.data.knead.strokes), 2)
        bpy.ops.knead.stroke_remove(index=1)
        self.assertLess(np.abs(self.seen(obj) - seen).max(), 1e-5 * self.size(obj))
        bpy.ops.knead.session_clear(restore=True)
        self.assertLess(np.abs(self.seen(obj) - self.seen_without_key(obj)).max(), 1e-5 * self.size(obj))

    def seen_without_key(self, obj):
        key = obj.data.shape_keys.key_blocks[1]
        key.mute = True
        bpy.context.view_layer.update()
        seen = self.seen(obj)
        key.mute = False
        return seen

    def test_another_pose_is_refused_and_the_session_stays(self):
        obj = make_hand()
        rig = pose(obj)
        seen = self.seen(obj)
        self.turned(obj, seen)
        text, key = obj.knead.session, key_values(obj, 1)
        turn(rig, 20)
        stroke = {"center": (0, 0, 0), "axis": (1, 0, 0), "angle_deg": 25, "inner": 0.1, "outer": 0.35}
        for work in (lambda: bpy.ops.knead.rotate(**stroke), bpy.ops.knead.session_rebuild):
            refuses(self, work, "another pose")
        self.assertEqual(obj.knead.session, text)
        self.same(key_values(obj, 1), key)
        turn(rig, 50)
        bpy.ops.knead.session_rebuild()
        self.assertEqual(obj.knead.session, text)
        self.assertLess(np.abs(key_values(obj, 1) - key).max(), 1e-5 * self.size(obj))

    def test_a_pose_after_strokes_at_rest_is_refused(self):
        obj = make_hand()
        rig = pose(obj, 0)
        self.turned(obj, self.seen(obj))
        self.assertIsNone(obj.data.shape_keys)
        text = obj.knead.session
        turn(rig, 40)
        refuses(self, lambda: self.turned(obj, self.seen(obj)), "another pose")
        self.assertEqual(obj.knead.session, text)
        after = self.vertices(obj)  # its strokes are those of the mesh itself, whatever the pose
        bpy.ops.knead.stroke_off(index=0, off=True)
        self.same(self.vertices(obj), self.base(obj))
        bpy.ops.knead.stroke_off(index=0, off=False)
        self.same(self.vertices(obj), after)
        self.assertIsNone(obj.data.shape_keys)

    def test_check_measures_what_is_shown(self):
        obj = make_hand()
        rig = pose(obj, 0)
        bpy.ops.knead.check()
        self.assertIn("Crossings: 0, before 0", obj.knead.report)
        turn(rig, 175)
        bpy.ops.knead.check()
        self.assertRegex(obj.knead.report, "Crossings: [1-9][0-9]*, before 0")

    def test_modifiers_that_add_vertices_stay(self):
        obj = make_hand()
        pose(obj)
        seen = self.seen(obj)
        for kind in ("MIRROR", "SUBSURF"):
            obj.modifiers.new(kind, kind)
        self.assertNotEqual(len(self.seen(obj)), len(seen))
        wanted = self.turned(obj, seen)
        self.assertTrue(all(m.show_viewport for m in obj.modifiers))
        obj.modifiers.remove(obj.modifiers["MIRROR"])
        obj.modifiers.remove(obj.modifiers["SUBSURF"])
        self.near(obj, wanted, seen)

    def test_a_modifier_that_is_not_linear(self):
        obj = make_hand()
        bend = obj.modifiers.new("Bend", "SIMPLE_DEFORM")
        bend.deform_method, bend.deform_axis, bend.angle = "BEND", "X", 1.2
        seen = self.seen(obj)
        self.near(obj, self.turned(obj, seen), seen)

    def test_what_is_not_shown_is_refused(self):
        obj = make_hand()
        obj.shape_key_add(name="Basis", from_mix=False)
        obj.shape_key_add(name="fist", from_mix=False).data[0].co.z += 0.1
        obj.shape_key_add(name="flat", from_mix=False)
        keys = obj.data.shape_keys.key_blocks
        keys["fist"].value, keys["flat"].value, obj.active_shape_key_index = 1, 0, 2
        flat = key_values(obj, 2)
        refuses(self, lambda: self.turned(obj, self.seen(obj)), "flat is not shown")
        self.same(key_values(obj, 2), flat)
        self.assertEqual(obj.knead.session, "")
        keys["flat"].value = 0.5
        bpy.context.view_layer.update()
        seen = self.seen(obj)
        self.near(obj, self.turned(obj, seen), seen)

    def test_a_session_becomes_a_shape_key_of_the_posed_mesh(self):
        from knead_blender.native import knead

        obj = make_hand()
        own, _ = self.vertices(obj), pose(obj)
        seen = self.seen(obj)
        path = session_file(self.folder, self.tip(seen, own))
        bpy.ops.knead.apply_session(filepath=path, to="SHAPE_KEY")
        self.near(obj, knead.deform(seen.astype(float), knead.Session.read(path), self.faces(obj)), seen)
        self.same(self.vertices(obj), own)

    def test_a_drag_follows_the_pointer_on_the_posed_mesh(self):
        from knead_blender import live
        from knead_blender.native import knead

        obj = make_hand()
        own, _ = self.vertices(obj), pose(obj)
        seen = self.seen(obj)
        kept, tip = live.begin(obj), np.array(self.tip(seen, own))
        self.assertLess(np.abs(kept.vertices - seen).max(), 1e-6)
        kept.set_strokes([knead.Implicit(path=[tip, tip + [0, 0.05, 0.1]], inner=0.1, outer=0.3)])
        live.show(obj, kept)
        self.near(obj, kept.vertices, seen)
        self.same(kept.link.edited, own)
        kept.set_strokes([])
        live.show(obj, kept)
        self.assertLess(np.abs(self.seen(obj) - seen).max(), 1e-6)

    def test_sculpt_mode(self):
        obj = make_hand()
        pose(obj)
        seen = self.seen(obj)
        bpy.ops.object.mode_set(mode="SCULPT")
        wanted = self.turned(obj, seen)
        bpy.ops.object.mode_set(mode="OBJECT")
        self.near(obj, wanted, seen)


class AfterBakes(Case):
    def baked(self, **how):
        obj = make_hand()
        bpy.ops.knead.apply_session(filepath=session_file(self.folder))
        bpy.context.scene.frame_set(1)
        bpy.ops.knead.bake(frames=5, **how)
        return obj

    def stroke(self):
        return bpy.ops.knead.rotate(center=(0, 0.9, 0), axis=(1, 0, 0), angle_deg=25, inner=0.1, outer=0.35)

    def test_a_stroke_goes_on_with_the_session(self):
        for drive in ("KEYFRAMES", "PROPERTY"):
            obj = self.baked(to="SHAPE_KEYS", drive=drive)
            base = self.base(obj)
            end = key_values(obj, 4)
            self.assertLess(np.abs(self.evaluated(obj, bpy.context.scene.frame_current) - end).max(), 1e-6)
            self.assertEqual(self.stroke(), {"FINISHED"})
            self.assertEqual(len(obj.data.knead.strokes), 3)
            self.same(self.base(obj), base)
            self.assertTrue((key_values(obj, 4) != end).any())
            bpy.ops.knead.stroke_remove(index=2)
            self.same(key_values(obj, 4), end)

    def test_elsewhere_in_time_it_is_refused(self):
        obj = self.baked(to="SHAPE_KEYS")
        text = obj.knead.session
        bpy.context.scene.frame_set(2)
        refuses(self, self.stroke, "another pose")
        self.assertEqual(obj.knead.session, text)

    def test_behind_a_cache_it_is_refused(self):
        obj = self.baked(to="MESH_CACHE", filepath=os.path.join(self.folder, "motion.pc2"))
        text = obj.knead.session
        refuses(self, self.stroke, "modifier Knead")
        self.assertEqual(obj.knead.session, text)
        bpy.context.scene.frame_set(2)
        refuses(self, lambda: bpy.ops.knead.apply_session(filepath=session_file(self.folder), to="SHAPE_KEY"), "not shown")
        self.assertIsNone(obj.data.shape_keys)
        obj.modifiers["Knead"].show_viewport = False
        self.stroke()
        self.assertEqual(len(obj.data.knead.strokes), 3)

    def test_a_failure_leaves_nothing(self):
        from knead_blender import bake

        obj = make_hand()
        bpy.ops.knead.apply_session(filepath=session_file(self.folder))
        after, text, actions = self.vertices(obj), obj.knead.session, len(bpy.data.actions)
        for name, drive in (("_add_keyframes", "KEYFRAMES"), ("_add_drivers", "PROPERTY")):
            made = getattr(bake.KNEAD_OT_bake, name)

            def fails(*arguments, made=made):
                made(*arguments)
                raise RuntimeError("no more")

            setattr(bake.KNEAD_OT_bake, name, staticmethod(fails))
            self.addCleanup(setattr, bake.KNEAD_OT_bake, name, staticmethod(made))
            refuses(self, lambda: bpy.ops.knead.bake(frames=5, to="SHAPE_KEYS", drive=drive), "no more")
            self.assertIsNone(obj.data.shape_keys)
            self.same(self.vertices(obj), after)
            self.assertEqual((obj.knead.session, len(bpy.data.actions)), (text, actions))
            self.assertNotIn("knead_along", obj)
        bpy.ops.knead.session_rebuild()
        self.same(self.vertices(obj), after)

    def test_of_a_posed_mesh_is_refused(self):
        obj = make_hand()
        pose(obj)
        bpy.ops.knead.rotate(center=(0, 0.3, 0.3), axis=(1, 0, 0), angle_deg=25, inner=0.1, outer=0.5)
        keys = len(obj.data.shape_keys.key_blocks)
        for to in ("SHAPE_KEYS", "MESH_CACHE"):
            refuses(self, lambda: bpy.ops.knead.bake(frames=3, to=to, filepath=os.path.join(self.folder, "a.pc2")), "posed")
        self.assertEqual(len(obj.data.shape_keys.key_blocks), keys)


run(Shown, AfterBakes)
