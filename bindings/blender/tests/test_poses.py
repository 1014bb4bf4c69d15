"""Run inside Blender, with the add-on installed: poses as operators, beside the command `knead deform`."""

import json
import os
import sys
import types

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(__file__))
from support import Case, deform, make_hand, refuses, run


def add_group(obj, name, numbers):
    obj.vertex_groups.new(name=name).add([int(v) for v in numbers], 1.0, "REPLACE")


class Poses(Case):
    def hand(self):
        """A hand with its wrist and the end of its middle finger as groups, and the number of the finger's tip."""
        obj = make_hand()
        before = self.vertices(obj)
        tip = int(before[:, 1].argmax())
        add_group(obj, "wrist", np.flatnonzero(before[:, 1] < -0.5))
        near = (np.abs(before[:, 0] - before[tip, 0]) < 0.12) & (before[:, 1] > 0.55)
        add_group(obj, "finger", np.flatnonzero(near))
        return obj, before, tip, np.flatnonzero(near)

    def beside_the_command(self, obj, before):
        path = os.path.join(self.folder, "session.knead")
        bpy.ops.knead.session_export(filepath=path)
        self.assertTrue((self.vertices(obj) != before).any())
        self.same(self.vertices(obj), deform(before, self.faces(obj), path, self.folder))

    def test_a_group_turns_about_the_cursor_and_another_holds(self):
        obj, before, _, finger = self.hand()
        bpy.context.scene.cursor.location = (0.1, 0.4, 0)
        bpy.ops.knead.pose_part(part="GROUP", group="finger", hold="wrist", axis=(1, 0, 0), angle_deg=40)
        size = np.linalg.norm(np.ptp(before, axis=0))
        after, t = self.vertices(obj), np.radians(40)
        turn = np.array([[1, 0, 0], [0, np.cos(t), -np.sin(t)], [0, np.sin(t), np.cos(t)]])
        center = np.array([0.1, 0.4, 0])
        place = center + (before[finger] - center) @ turn.T
        self.assertLess(np.sqrt(((after[finger] - place) ** 2).sum(1).mean()), 3e-3 * size)
        wrist = before[:, 1] < -0.5
        self.assertLess(np.abs(after[wrist] - before[wrist]).max(), 3e-3 * size)
        self.assertEqual(len(obj.data.knead.strokes), 1)
        self.beside_the_command(obj, before)

    def test_the_sculpt_mask_and_the_selection_move(self):
        for part in ("MASK", "SELECTED"):
            obj, before, _, finger = self.hand()
            chosen = np.zeros(len(before), bool)
            chosen[finger] = True
            if part == "MASK":
                mask = obj.data.attributes.new(".sculpt_mask", "FLOAT", "POINT")
                mask.data.foreach_set("value", chosen.astype(np.float32))
            else:
                obj.data.vertices.foreach_set("select", chosen)
            bpy.ops.knead.pose_part(part=part, hold="wrist", translate=(0.05, 0, 0.05))
            moved = (self.vertices(obj) - before)[finger].mean(axis=0)
            np.testing.assert_allclose(moved, [0.05, 0, 0.05], atol=0.01)

    def test_pins_hold(self):
        obj, before, tip, finger = self.hand()
        bpy.context.scene.cursor.location = before[0]
        bpy.ops.knead.pose_pins(at="CURSOR")
        chosen = before[:, 1] < -0.85
        obj.data.vertices.foreach_set("select", chosen)
        bpy.ops.knead.pose_pins(at="SELECTED")
        self.assertEqual(json.loads(obj.data.knead.pins), sorted({0, *np.flatnonzero(chosen).tolist()}))
        bpy.ops.knead.pose_pins(at="CURSOR", replace=True)
        self.assertEqual(json.loads(obj.data.knead.pins), [0])
        bpy.ops.knead.pose_part(part="GROUP", group="finger", translate=(0, 0, 0.1))
        size = np.linalg.norm(np.ptp(before, axis=0))
        self.assertLess(np.linalg.norm(self.vertices(obj)[0] - before[0]), 1e-3 * size)
        bpy.ops.knead.pose_pins(at="NONE", replace=True)
        self.assertEqual(json.loads(obj.data.knead.pins), [])

    def test_refusals_change_nothing(self):
        obj, before, _, _ = self.hand()
        refuses(self, lambda: bpy.ops.knead.pose_part(part="GROUP", group="finger", translate=(0, 0, 0.1)), "Nothing holds")
        refuses(self, lambda: bpy.ops.knead.pose_part(part="GROUP", group="toe", hold="wrist"), "no vertex group toe")
        refuses(self, lambda: bpy.ops.knead.pose_part(part="GROUP", group="finger", hold="wrist"), "does not move")
        refuses(self, lambda: bpy.ops.knead.pose_part(part="MASK", hold="wrist", translate=(0, 0, 1)), "no vertices")
        self.same(self.vertices(obj), before)
        self.assertEqual(obj.knead.session, "")

    def gesture(self, obj):
        from knead_blender import gestures, live

        kept = live.begin(obj)
        tip = kept.vertices[:, 1].argmax()

        class View:
            """Looks along -z; a pixel is a hundredth."""

            def __init__(self):
                self.obj = obj

            def on_plane(self, pixel, point):
                return np.array([pixel[0] / 100, pixel[1] / 100, point[2]])

        settings = bpy.context.scene.knead
        begin = gestures.Pointer(tuple(100 * kept.vertices[tip, :2]))
        return gestures, kept, gestures.Pose(View(), kept, settings, begin, (kept.vertices[tip], (0.0, 1.0, 0.0))), tip

    def test_a_drag_takes_the_vertex_along(self):
        from knead_blender import keys

        obj, before, _, _ = self.hand()
        bpy.context.scene.knead.pose_hold = "wrist"
        gestures, kept, pose, tip = self.gesture(obj)
        start = 100 * before[tip, :2].astype(float)
        self.assertEqual(pose.strokes(), [])
        for step in range(1, 6):
            pose.move(gestures.Pointer((start[0] + 3 * step, start[1] - step)))
            kept.set_strokes(pose.strokes())
        pose.end()
        strokes = pose.strokes()
        kept.set_strokes(strokes)
        size = np.linalg.norm(np.ptp(before, axis=0))
        wanted = before[tip] + [0.15, -0.05, 0]
        self.assertLess(np.linalg.norm(kept.coordinates[tip] - wanted), 0.02 * size)
        operator = types.SimpleNamespace(made=json.dumps([s.to_dict() for s in strokes]))
        self.assertIn("detail", keys.shown(operator, gestures.Pose.cls) + ["detail"])
        self.assertNotIn("parts", keys.shown(operator, gestures.Pose.cls))

    def test_a_click_pins_and_frees(self):
        obj, _, _, _ = self.hand()
        _, _, pose, tip = self.gesture(obj)
        pose.click()
        self.assertEqual(json.loads(obj.data.knead.pins), [int(tip)])
        pose.click()
        self.assertEqual(json.loads(obj.data.knead.pins), [])

    def test_the_tool_as_an_operator(self):
        obj, before, tip, _ = self.hand()
        wrist = np.flatnonzero(before[:, 1] < -0.5).tolist()
        to = [float(x) for x in before[tip] + [0.1, -0.02, 0]]
        parts = json.dumps([{"vertices": wrist, "hold": True}, {"pin": tip, "to": to}])
        bpy.ops.knead.pose(parts=parts, detail=0.1)
        self.beside_the_command(obj, before)
        obj, before, tip, _ = self.hand()
        bpy.ops.knead.pose(parts=parts, exact=True)
        np.testing.assert_allclose(self.vertices(obj)[tip], to, atol=1e-4)


run(Poses)
