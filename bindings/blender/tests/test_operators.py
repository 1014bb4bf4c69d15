"""Run inside Blender, with the add-on installed: the operators on sessions beside the command `knead deform`."""

import json
import os
import struct
import sys

import bmesh
import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(__file__))
from support import ADDON, Case, deform, enable, key_values, make_hand, refuses, run, session_file


def volume(obj):
    own = bmesh.new()
    own.from_mesh(obj.data)
    result = own.calc_volume()
    own.free()
    return result


class Operators(Case):
    def test_same_bits_as_the_command(self):
        obj = make_hand()
        before, faces = self.vertices(obj), self.faces(obj)
        self.assertEqual(bpy.ops.knead.apply_session(filepath=session_file(self.folder)), {"FINISHED"})
        after = self.vertices(obj)
        self.assertTrue((after != before).any())
        self.same(after, deform(before, faces, session_file(self.folder), self.folder))

    def test_switch_off_move_and_rebuild(self):
        obj = make_hand()
        before = self.vertices(obj)
        bpy.ops.knead.apply_session(filepath=session_file(self.folder))
        after = self.vertices(obj)
        for i in range(2):
            bpy.ops.knead.stroke_off(index=i, off=True)
        self.same(self.vertices(obj), before)
        for i in range(2):
            obj.data.knead.strokes[i].on = True
        self.same(self.vertices(obj), after)
        bpy.ops.knead.stroke_move(index=0, to=1)
        self.assertTrue((self.vertices(obj) != after).any())
        bpy.ops.knead.stroke_move(index=1, to=0)
        bpy.ops.knead.session_rebuild()
        self.same(self.vertices(obj), after)
        bpy.ops.knead.session_clear(restore=True)
        self.same(self.vertices(obj), before)
        self.assertEqual(obj.knead.session, "")

    def test_export_and_import(self):
        obj = make_hand()
        bpy.ops.knead.apply_session(filepath=session_file(self.folder))
        after, path = self.vertices(obj), os.path.join(self.folder, "back.knead")
        bpy.ops.knead.session_export(filepath=path)
        other = make_hand()
        bpy.ops.knead.session_import(filepath=path)
        self.same(self.vertices(other), after)
        self.assertEqual(other.knead.session, obj.knead.session)

    def test_fit_to_the_active_object(self):
        obj = make_hand()
        other = make_hand()
        bpy.ops.knead.apply_session(filepath=session_file(self.folder))
        goal = self.vertices(other)
        other.location = (3, 0, 1)
        bpy.context.view_layer.update()
        self.same(self.vertices(obj), self.vertices(make_hand()))
        bpy.context.view_layer.objects.active = other
        bpy.ops.object.select_all(action="DESELECT")
        self.assertFalse(bpy.ops.knead.fit.poll())
        obj.select_set(True)
        other.select_set(True)
        self.assertEqual(bpy.ops.knead.fit(), {"FINISHED"})
        self.same(self.vertices(other), goal)
        there = goal + np.array([3, 0, 1])
        size = np.linalg.norm(np.ptp(goal, axis=0))
        self.assertLess(np.linalg.norm(self.vertices(obj) - there, axis=1).mean(), 0.02 * size)
        import knead_blender.state as state

        tools = {stroke.tool for stroke in state.parse(obj.knead.session)}
        self.assertTrue(tools <= {"grid", "implicit", "rotate", "pins"}, tools)

    def test_bend_along_a_curve(self):
        bpy.ops.mesh.primitive_cylinder_add(vertices=24, depth=6, radius=0.3, location=(1, 2, 0))
        obj = bpy.context.object
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.mesh.subdivide(number_cuts=20)
        bpy.ops.object.mode_set(mode="OBJECT")
        before = self.vertices(obj)
        with self.assertRaisesRegex(RuntimeError, "Select one curve"):
            bpy.ops.knead.bend_along()
        bpy.ops.curve.primitive_bezier_curve_add(radius=3, location=(0, 0, 1), rotation=(0.4, 0, 0.7))
        curve = bpy.context.object
        curve.data.bevel_depth = 0.2  # which does not matter
        obj.select_set(True)
        bpy.context.view_layer.objects.active = obj
        bpy.context.view_layer.update()
        self.assertEqual(bpy.ops.knead.bend_along(fixed="middle", twist_deg=30), {"FINISHED"})
        self.assertEqual((len(bpy.data.curves), len(bpy.data.objects["BezierCurve"].data.splines)), (1, 1))
        after = self.vertices(obj)
        # The ends of its axis lie on the curve's line, or straight on beyond it; the volume of its triangles stays.
        line = (np.array(curve.matrix_world) @ np.vstack([[[*p.co, 1] for p in curve.data.splines[0].bezier_points]]).T).T[:, :3]
        world = after @ np.array(obj.matrix_world)[:3, :3].T + np.array(obj.matrix_world)[:3, 3]
        middle = world[np.abs(before[:, 2]) < 0.2].mean(axis=0)
        self.assertLess(np.linalg.norm(middle - line.mean(axis=0)), 0.6)
        import knead_blender.state as state

        (stroke,) = state.parse(obj.knead.session)
        self.assertEqual((stroke.tool, stroke.twist_deg, stroke.fixed), ("curve", 30, "middle"))
        self.assertEqual(len(stroke.to), 13)
        bent = volume(obj)
        bpy.ops.knead.session_clear(restore=True)
        self.same(self.vertices(obj), before)
        self.assertLess(abs(bent / volume(obj) - 1), 0.01)
        curve.data.splines[0].use_cyclic_u = True
        with self.assertRaisesRegex(RuntimeError, "a closed one"):
            bpy.ops.knead.bend_along()
        self.same(self.vertices(obj), before)

    def test_clothes_are_taken_along(self):
        obj, clothes = make_hand(), make_hand()
        rest = self.vertices(obj)
        for each in (obj, clothes):
            each.select_set(True)
        bpy.context.view_layer.objects.active = obj
        bpy.context.view_layer.update()
        self.assertFalse(bpy.ops.knead.take_along.poll())
        path = session_file(self.folder)
        bpy.ops.knead.apply_session(filepath=path)
        clothes.location, clothes.scale = (0.01, 0, 0), (1.02, 1.02, 1.02)
        bpy.context.view_layer.update()
        for _ in range(2):  # the second time from rest again
            self.assertEqual(bpy.ops.knead.take_along(), {"FINISHED"})
            self.assertEqual(len(clothes.data.shape_keys.key_blocks), 2)
            self.same(self.vertices(clothes), rest)
            import knead_blender.state as state

            flow = state.parse(obj.knead.session).resolve(rest.astype(np.float64), self.faces(obj))
            expected = (state.knead.deform(1.02 * rest.astype(np.float64) + [0.01, 0, 0], flow) - [0.01, 0, 0]) / 1.02
            found = key_values(clothes, 1)
            self.assertLess(np.abs(found - expected).max(), 1e-5)
            self.assertGreater(np.abs(found - rest).max(), 0.05)
        clothes.select_set(False)
        with self.assertRaisesRegex(RuntimeError, "Select what moves along"):
            bpy.ops.knead.take_along()

    def test_shape_keys(self):
        obj = make_hand()
        before, path = self.vertices(obj), session_file(self.folder)
        bpy.ops.knead.apply_session(filepath=path, to="SHAPE_KEY")
        expected = deform(before, self.faces(obj), path, self.folder)
        self.same(self.vertices(obj), before)
        self.same(key_values(obj, -1), expected)
        obj.active_shape_key_index = 1
        bpy.ops.knead.apply_session(filepath=path)
        self.same(key_values(obj, -1), deform(expected, self.faces(obj), path, self.folder))
        self.same(key_values(obj, 0), before)
        obj.active_shape_key_index = 0
        refuses(self, bpy.ops.knead.session_rebuild, "belongs to")

    def test_the_world_space_of_a_turned_and_scaled_child(self):
        obj = make_hand()
        parent = bpy.data.objects.new("parent", None)
        bpy.context.collection.objects.link(parent)
        parent.location, obj.parent = (3, 1, 0), parent
        obj.rotation_euler, obj.scale = (0.3, 0.2, 1), (2, 1, 0.5)
        bpy.context.view_layer.update()
        before, m = self.vertices(obj), np.array(obj.matrix_world, np.float64)
        tip = (m @ [*before[before[:, 1].argmax()].astype(float), 1])[:3]
        path = session_file(self.folder, tip)
        bpy.ops.knead.apply_session(filepath=path, space="WORLD")
        import knead_blender.native as native

        world = before.astype(float) @ m[:3, :3].T + m[:3, 3]
        expected = native.knead.deform(world, native.knead.Session.read(path), self.faces(obj))
        found = self.vertices(obj).astype(float) @ m[:3, :3].T + m[:3, 3]
        self.assertGreater(np.abs(found - world).max(), 0.01)
        self.assertLess(np.abs(found - expected).max(), 1e-5)
        still = (expected == world).all(axis=1)
        self.same(self.vertices(obj)[still], before[still])

    def test_what_is_refused_changes_nothing(self):
        obj = make_hand()
        before = self.vertices(obj)
        bad = os.path.join(self.folder, "bad.knead")
        with open(bad, "w") as file:
            file.write('{"knead": 1}\n{"tool": "implicit", "inner": -1}\n')
        refuses(self, lambda: bpy.ops.knead.apply_session(filepath=bad), "bad.knead:2")
        bpy.ops.object.mode_set(mode="EDIT")
        refuses(self, lambda: bpy.ops.knead.apply_session(filepath=session_file(self.folder)), "Tab")
        bpy.ops.object.mode_set(mode="OBJECT")
        self.same(self.vertices(obj), before)
        self.assertEqual(obj.knead.session, "")

    def test_a_refused_stroke_leaves_the_session(self):
        obj = make_hand()
        bpy.ops.knead.apply_session(filepath=session_file(self.folder))
        after, text, base = self.vertices(obj), obj.knead.session, self.base(obj)
        surface = os.path.join(self.folder, "surface.knead")
        with open(surface, "w") as file:
            file.write('{"knead": 1}\n{"tool": "handles", "full_vertices": [999999], "zero_vertices": [1], ')
            file.write('"motion": {"translate": [0, 0.1, 0]}}\n')
        refuses(self, lambda: bpy.ops.knead.apply_session(filepath=surface), "999999")
        self.same(self.vertices(obj), after)
        self.same(self.base(obj), base)
        self.assertEqual(obj.knead.session, text)
        refuses(self, lambda: bpy.ops.knead.apply_session(filepath=session_file(self.folder), space="WORLD"), "own space")

    def test_strokes_are_edited_and_removed(self):
        obj = make_hand()
        bpy.ops.knead.apply_session(filepath=session_file(self.folder))
        first = json.loads(obj.knead.session.splitlines()[1])
        bpy.ops.knead.stroke_remove(index=1)
        self.assertEqual(len(obj.data.knead.strokes), 1)
        bpy.ops.knead.stroke_edit(index=0, line=json.dumps({**first, "strength": 0}))
        self.same(self.vertices(obj), self.base(obj))
        refuses(self, lambda: bpy.ops.knead.stroke_edit(index=0, line='{"tool": "none"}'), "none")
        refuses(self, lambda: bpy.ops.knead.stroke_remove(index=5), "no number 6")

    def test_the_list_of_an_object_that_is_not_active(self):
        obj = make_hand()
        bpy.ops.knead.apply_session(filepath=session_file(self.folder))
        after, other = self.vertices(obj), make_hand()
        for stroke in obj.data.knead.strokes:
            stroke.on = False
        self.same(self.vertices(obj), self.base(obj))
        self.same(self.vertices(other), self.base(obj))
        self.assertTrue((after != self.base(obj)).any())

    def test_a_mesh_that_was_changed_elsewhere(self):
        obj = make_hand()
        bpy.ops.knead.apply_session(filepath=session_file(self.folder))
        after = self.vertices(obj)
        obj.data.vertices[0].co.x += 0.1
        refuses(self, bpy.ops.knead.session_rebuild, "changed elsewhere")
        self.assertNotEqual(obj.data.vertices[0].co.x, after[0, 0])
        bpy.ops.knead.session_rebuild(discard=True)
        self.same(self.vertices(obj), after)
        obj.data.vertices[0].co.x += 0.1
        changed = self.vertices(obj)
        bpy.ops.knead.apply_session(filepath=session_file(self.folder))  # begins anew
        self.same(self.vertices(obj), deform(changed, self.faces(obj), session_file(self.folder), self.folder))
        self.assertEqual(len(obj.data.knead.strokes), 2)

    def test_a_vertex_group_and_the_sculpt_mask_hold(self):
        obj = make_hand()
        before = self.vertices(obj)
        group = obj.vertex_groups.new(name="held")
        held = np.flatnonzero(before[:, 1] > before[:, 1].max() - 0.05)
        group.add(held.tolist(), 1.0, "REPLACE")
        bpy.ops.knead.add_mask(group="held", width=0.05)
        bpy.ops.knead.apply_session(filepath=session_file(self.folder))
        after = self.vertices(obj)
        self.same(after[held], before[held])
        self.assertTrue((after != before).any())

    def test_attributes_modifiers_and_duplicates_survive(self):
        obj = make_hand()
        uv = obj.data.uv_layers.new(name="uv")
        uv.data[5].uv = (0.25, 0.75)
        obj.data.color_attributes.new("colour", "BYTE_COLOR", "CORNER").data[7].color = (0.5, 0, 0, 1)
        obj.modifiers.new("Subdivision", "SUBSURF")
        twin = bpy.data.objects.new("twin", obj.data)
        bpy.context.collection.objects.link(twin)
        bpy.ops.knead.apply_session(filepath=session_file(self.folder))
        self.assertEqual(tuple(obj.data.uv_layers["uv"].data[5].uv), (0.25, 0.75))
        self.assertAlmostEqual(obj.data.color_attributes["colour"].data[7].color[0], 0.5, places=2)
        self.assertEqual([m.type for m in obj.modifiers], ["SUBSURF"])
        self.assertEqual(twin.knead.session, obj.knead.session)
        self.same(self.vertices(twin), self.vertices(obj))

    def test_check(self):
        obj = make_hand()
        bpy.ops.knead.apply_session(filepath=session_file(self.folder))
        bpy.ops.knead.check()
        self.assertIn("Crossings: 0, before 0", obj.knead.report)
        self.assertFalse(any(p.select for p in obj.data.polygons))
        vertices = self.vertices(obj)
        vertices[vertices[:, 1].argmax(), 1] -= 2  # the tip through the palm
        obj.data.vertices.foreach_set("co", vertices.ravel())
        bpy.ops.knead.check()
        self.assertNotIn("Crossings: 0,", obj.knead.report)
        from knead_blender.native import knead

        crossing = np.unique(knead.crossings(vertices, self.faces(obj)))
        self.assertEqual([p.index for p in obj.data.polygons if p.select], crossing.tolist())

    def test_bake(self):
        obj = make_hand()
        base = self.vertices(obj)
        bpy.ops.knead.apply_session(filepath=session_file(self.folder))
        end, path = self.vertices(obj), os.path.join(self.folder, "motion.pc2")
        bpy.ops.knead.bake(frames=5, to="MESH_CACHE", filepath=path)
        with open(path, "rb") as file:
            header = struct.unpack("<12siiffi", file.read(32))
            frames = np.frombuffer(file.read(), "<f4").reshape(5, -1, 3)
        self.assertEqual(header[2:], (len(base), 0.0, 1.0, 5))
        self.same(frames[0], base)
        self.same(frames[-1], end)
        self.same(self.evaluated(obj, 3), frames[2])
        obj.modifiers.clear()
        bpy.ops.knead.bake(frames=5, to="SHAPE_KEYS")
        self.assertLess(np.abs(self.evaluated(obj, 3) - frames[2]).max(), 1e-6)

    def test_a_property_drives_the_motion(self):
        obj = make_hand()
        bpy.ops.knead.apply_session(filepath=session_file(self.folder))
        end, base = self.vertices(obj), self.base(obj)
        path = os.path.join(self.folder, "motion.pc2")
        bpy.ops.knead.bake(frames=5, to="MESH_CACHE", filepath=path)
        with open(path, "rb") as file:
            frames = np.frombuffer(file.read()[32:], "<f4").reshape(5, -1, 3)
        obj.modifiers.clear()
        bpy.ops.knead.bake(frames=5, to="SHAPE_KEYS", drive="PROPERTY")
        for along, expected in ((0.0, base), (0.25, frames[1]), (0.375, 0.5 * (frames[1] + frames[2])), (1.0, end)):
            obj["knead_along"] = along
            obj.update_tag()
            self.assertLess(np.abs(self.evaluated(obj, 1) - expected).max(), 1e-6, along)
        self.assertTrue(all(d.driver.is_simple_expression for d in obj.data.shape_keys.animation_data.drivers))

    def test_gltf_shows_the_motion(self):
        obj = make_hand()
        bpy.ops.knead.apply_session(filepath=session_file(self.folder))
        moved = np.abs(self.vertices(obj) - self.base(obj)).max()
        bpy.ops.knead.bake(frames=4, to="SHAPE_KEYS")
        path = os.path.join(self.folder, "motion.glb")
        bpy.ops.export_scene.gltf(filepath=path, export_format="GLB")
        with open(path, "rb") as file:
            data = file.read()
        head = json.loads(data[20 : 20 + struct.unpack("<I", data[12:16])[0]])
        mesh = head["meshes"][0]["primitives"][0]
        self.assertEqual(len(mesh["targets"]), 3)
        last = head["accessors"][mesh["targets"][-1]["POSITION"]]
        self.assertAlmostEqual(max(map(abs, (*last["min"], *last["max"]))), float(moved), places=5)
        channels = [c["target"]["path"] for animation in head["animations"] for c in animation["channels"]]
        self.assertIn("weights", channels)

    def test_save_and_reopen_and_without_the_addon(self):
        obj = make_hand()
        name = obj.name
        bpy.ops.knead.apply_session(filepath=session_file(self.folder))
        after, text = self.vertices(obj), obj.knead.session
        path = os.path.join(self.folder, "saved.blend")
        bpy.ops.wm.save_as_mainfile(filepath=path)
        bpy.ops.preferences.addon_disable(module=ADDON)
        self.assertFalse(hasattr(bpy.types.Object, "knead"))
        bpy.ops.wm.open_mainfile(filepath=path)
        self.same(self.vertices(bpy.data.objects[name]), after)
        bpy.ops.wm.save_as_mainfile(filepath=path)
        enable()
        bpy.ops.wm.open_mainfile(filepath=path)
        obj = bpy.data.objects[name]
        bpy.context.view_layer.objects.active = obj
        self.assertEqual(obj.knead.session, text)
        bpy.ops.knead.session_rebuild()
        self.same(self.vertices(obj), after)


run(Operators)
