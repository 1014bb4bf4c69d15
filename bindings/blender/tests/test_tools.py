"""Run inside Blender, with the add-on installed: the tools as operators, beside the command `knead deform`."""

import json
import os
import sys
import types

import bpy
import numpy as np

sys.path.insert(0, os.path.dirname(__file__))
from support import Case, deform, make_hand, refuses, run


def tip_of(case, obj):
    vertices = case.vertices(obj)
    return [float(x) for x in vertices[vertices[:, 1].argmax()]]


class Tools(Case):
    def beside_the_command(self, obj, before):
        path = os.path.join(self.folder, "session.knead")
        bpy.ops.knead.session_export(filepath=path)
        self.assertTrue((self.vertices(obj) != before).any())
        self.same(self.vertices(obj), deform(before, self.faces(obj), path, self.folder))

    def test_every_tool_has_the_bits_of_the_command(self):
        obj = make_hand()
        before = self.vertices(obj)
        tip = tip_of(self, obj)
        ball = {"inner": 0.1, "outer": 0.3}
        below = [tip[0], tip[1] - 0.3, tip[2]]
        bpy.ops.knead.pull(path=json.dumps([tip, [tip[0], tip[1] + 0.1, tip[2]]]), **ball)
        bpy.ops.knead.rotate(center=tip, axis=(1, 0, 0), angle_deg=20, **ball)
        bpy.ops.knead.stretch(center=tip, axis=(0, 1, 0), factor=1.2, **ball)
        bpy.ops.knead.twist(center=below, axis=(0, 1, 0), normal=(0, -1, 0), rate_deg=50, inner=-0.1, outer=0.1)
        bpy.ops.knead.bend(center=below, axis=(1, 0, 0), normal=(0, -1, 0), angle_deg=20, width=0.2)
        bpy.ops.knead.paint(outer=0.2, depth=0.02, samples=json.dumps([{"point": below, "normal": [0, 0, 1]}]))
        self.assertEqual(len(obj.data.knead.strokes), 6)
        self.beside_the_command(obj, before)

    def test_the_first_stroke_keeps_the_base(self):
        obj = make_hand()
        before = self.vertices(obj)
        bpy.ops.knead.rotate(center=tip_of(self, obj), axis=(1, 0, 0), angle_deg=20, inner=0.1, outer=0.3)
        self.same(self.base(obj), before)
        bpy.ops.knead.session_clear(restore=True)
        self.same(self.vertices(obj), before)

    def test_mirror(self):
        obj = make_hand()
        before = self.vertices(obj)
        tip = tip_of(self, obj)
        bpy.ops.knead.rotate(center=tip, axis=(1, 0, 0), angle_deg=20, inner=0.1, outer=0.3, mirror={"X"})
        (line,) = (json.loads(line) for line in obj.knead.session.splitlines()[1:])
        self.assertEqual(line["mirror"], "x")
        np.testing.assert_allclose(line["center"], tip, rtol=1e-6)
        self.beside_the_command(obj, before)

    def test_sculpt_mode(self):
        obj = make_hand()
        before = self.vertices(obj)
        bpy.ops.object.mode_set(mode="SCULPT")
        bpy.ops.knead.rotate(center=tip_of(self, obj), axis=(1, 0, 0), angle_deg=20, inner=0.1, outer=0.3)
        self.assertEqual(obj.mode, "SCULPT")
        self.beside_the_command(obj, before)

    def test_after_an_edit_of_the_session(self):
        obj = make_hand()
        before = self.vertices(obj)
        turn = {"center": tip_of(self, obj), "axis": (1, 0, 0), "inner": 0.1, "outer": 0.3}
        bpy.ops.knead.rotate(angle_deg=20, **turn)
        bpy.ops.knead.rotate(angle_deg=-10, **turn)
        bpy.ops.knead.stroke_remove(index=0)
        bpy.ops.knead.rotate(angle_deg=5, **turn)
        self.assertEqual(len(obj.data.knead.strokes), 2)
        self.beside_the_command(obj, before)

    def test_what_is_refused_changes_nothing(self):
        obj = make_hand()
        before = self.vertices(obj)
        refuses(self, lambda: bpy.ops.knead.rotate(center=(0, 0, 0), axis=(1, 0, 0), angle_deg=5, inner=2, outer=1), "inner")
        refuses(self, lambda: bpy.ops.knead.pull(path="[[0, 0, 0", inner=0.1, outer=0.3), "delimiter")
        refuses(self, lambda: bpy.ops.knead.pull(inner=0.1, outer=0.3), "path")
        self.same(self.vertices(obj), before)
        self.assertEqual(obj.knead.session, "")

    def gesture(self, kind, **settings):
        """Returns a gesture that begins at the middle of a sphere of 100 pixels a unit, seen from above."""
        import bmesh

        from knead_blender import gestures, live

        mesh = bpy.data.meshes.new("ball")
        form = bmesh.new()
        bmesh.ops.create_icosphere(form, subdivisions=4, radius=1)
        form.to_mesh(mesh)
        obj = bpy.data.objects.new("ball", mesh)
        bpy.context.collection.objects.link(obj)
        bpy.context.view_layer.objects.active = obj
        view = types.SimpleNamespace(
            obj=obj,
            ray=lambda pixel: ([pixel[0] / 100, pixel[1] / 100, 5], [0, 0, -1]),
            on_plane=lambda pixel, point: np.array([pixel[0] / 100, pixel[1] / 100, point[2]]),
            direction=lambda axis: np.eye(3)[axis],
            pixel_size=lambda point: 0.01,
            pixels=lambda points: 100 * np.asarray(points)[:, :2],
        )
        chosen = bpy.context.scene.knead
        for key, value in settings.items():
            setattr(chosen, key, value)
        kept = live.begin(obj)
        begin = gestures.Pointer((0, 0), pressure=settings.pop("first", 1.0), ctrl=False)
        return gestures, gestures.ALL[kind](view, kept, chosen, begin, kept.surface.hit(*view.ray((0, 0))))

    def test_ctrl_snaps_and_numbers_are_taken(self):
        gestures, rotate = self.gesture("rotate")
        rotate.move(gestures.Pointer((-47, 0)))
        self.assertAlmostEqual(rotate.strokes()[0].angle_deg, 23.5)
        rotate.move(gestures.Pointer((-47, 0), ctrl=True))
        self.assertEqual(rotate.strokes()[0].angle_deg, 30)
        rotate.move(gestures.Pointer((-47, 0), ctrl=True, typed=-7.5))
        self.assertEqual(rotate.strokes()[0].angle_deg, -7.5)
        rotate.move(gestures.Pointer((0, 0)))
        self.assertEqual(rotate.strokes(), [])
        gestures, pull = self.gesture("pull", radius=0.1)
        step = 0.1 * pull.radius
        for pixel in ((10, 0), (30, 2), (57, 5)):
            pull.move(gestures.Pointer(pixel))
        self.assertEqual(len(pull.strokes()[0].path), 4)
        pull.move(gestures.Pointer((57, 0), ctrl=True))
        (stroke,) = pull.strokes()
        self.assertEqual(len(stroke.path), 2)
        self.assertAlmostEqual(pull.amount() / step, round(0.57 / step), places=6)
        pull.move(gestures.Pointer((57, 0), typed=0.2))
        self.assertAlmostEqual(pull.amount(), 0.2)
        _, stretch = self.gesture("stretch")
        stretch.move(gestures.Pointer((0, 0), typed=25.0))
        self.assertAlmostEqual(stretch.strokes()[0].factor, 1.25)

    def test_a_pen_paints_finer_or_less(self):
        for kind in ("NONE", "RADIUS", "DEPTH"):
            gestures, paint = self.gesture("paint", radius=0.05, pressure=kind)
            for i in range(1, 30):
                paint.move(gestures.Pointer((i, 0), pressure=1 - i / 40))
            paint.end()
            strokes = paint.strokes()
            radii = [stroke.bump for stroke in strokes]
            dabs = sum(len(stroke.samples) for stroke in strokes)
            if kind == "RADIUS":
                self.assertGreater(len(radii), 2)
                self.assertEqual(radii, sorted(radii, reverse=True))
            else:
                self.assertEqual(len(radii), 1)
                full = dabs if kind == "NONE" else full  # noqa: F821: NONE comes first
                self.assertEqual(kind == "DEPTH", dabs < full)

    def test_paint_goes_out_and_with_ctrl_in(self):
        for ctrl in (False, True):
            gestures, first = self.gesture("paint", radius=0.05, depth=0.1)
            begin = gestures.Pointer((0, 0), ctrl=ctrl)
            paint = gestures.Paint(first.view, first.live, first.settings, begin, (first.point, first.normal))
            paint.end()
            first.live.set_strokes(paint.strokes())
            pole = first.live.base[:, 2].argmax()
            rise = float(first.live.coordinates[pole, 2]) - 1
            self.assertGreater(-rise if ctrl else rise, 0.05 * first.radius)

    def height(self, kind, path, **settings):
        """Returns how far the pole of a sphere rises under a brush, in radii of the brush, and the lowest place nearby."""
        gestures, brush = self.gesture(kind, radius=0.08, **settings)
        for pixel in path:
            brush.move(gestures.Pointer(pixel))
        brush.end()
        brush.live.set_strokes(brush.strokes())
        return np.linalg.norm(brush.live.coordinates.astype(float), axis=1) - 1, brush

    def test_brushes_take_their_volume_from_far_around(self):
        for kind in ("move", "snakehook"):
            far, brush = self.height(kind, [(10 * i, 0) for i in range(1, 9)])
            (stroke,) = brush.strokes()
            self.assertEqual((stroke.falloff, stroke.bump), ("wide", brush.radius))
            self.assertGreater(np.abs(far).max(), 0.05)
            self.assertLess(-far.min(), 0.05)
        far, _ = self.height("crease", [(4 * i, 0) for i in range(8)], pinch=0.7)
        self.assertLess(far.min(), -0.01)
        self.assertLess(far.max(), -0.5 * far.min())

    def test_flatten_levels(self):
        far, brush = self.height("flatten", [(0.5 * i, 0) for i in range(20)], pinch=1.0)
        self.assertLess(far.min(), -0.002)
        (stroke,) = brush.strokes()
        self.assertLess(stroke.pinch, 0)
        # The planes are the mean ones, below the pole.
        self.assertLess(stroke.samples[0]["point"][2], 1 - 1e-3)

    def test_custom_normals_survive(self):
        obj = make_hand()
        obj.data.normals_split_custom_set([(0, 0, 1)] * len(obj.data.loops))
        bpy.ops.knead.rotate(center=tip_of(self, obj), axis=(1, 0, 0), angle_deg=20, inner=0.1, outer=0.3)
        self.assertTrue(obj.data.has_custom_normals)

    def test_a_stamp_needs_a_closed_mesh(self):
        from knead_blender import stamps, state

        obj = make_hand()
        settings = bpy.context.scene.knead
        path, points = stamps.make(settings, obj)
        self.assertTrue(os.path.exists(path))
        self.assertAlmostEqual(np.abs(points).max(), 1, places=2)
        again, _ = stamps.make(settings, obj)
        self.assertEqual(path, again)
        settings.stamp = obj
        with self.assertRaisesRegex(state.Refusal, "own stamp"):
            stamps.make(settings, obj)
        bpy.ops.mesh.primitive_plane_add()
        settings.stamp = bpy.context.object
        with self.assertRaisesRegex(state.Refusal, "not closed"):
            stamps.make(settings, obj)

    def press_a_stamp(self, obj):
        from knead_blender import stamps

        tip = tip_of(self, obj)
        path, _ = stamps.make(bpy.context.scene.knead, obj)
        way = json.dumps([[tip[0], tip[1] + 0.08, tip[2]], [tip[0], tip[1] + 0.02, tip[2]]])
        bpy.ops.knead.stamp(mesh=path, pose=json.dumps((np.eye(3) * 0.05).tolist()), path=way)
        return path

    def test_stamps_are_temporary_until_the_first_save(self):
        obj = make_hand()
        user = bpy.utils.user_resource("DATAFILES") or self.folder
        there = sorted(os.listdir(user)) if os.path.isdir(user) else []
        path = self.press_a_stamp(obj)
        self.assertTrue(path.startswith(bpy.app.tempdir))
        self.assertEqual(sorted(os.listdir(user)) if os.path.isdir(user) else [], there)
        exported = os.path.join(self.folder, "of.knead")
        bpy.ops.knead.session_export(filepath=exported)
        with open(exported) as file:
            self.assertNotIn(bpy.app.tempdir, file.read())
        after, name, saved = self.vertices(obj), obj.name, os.path.join(self.folder, "saved", "hand.blend")
        os.makedirs(os.path.dirname(saved))
        bpy.ops.wm.save_as_mainfile(filepath=saved)
        os.remove(path)
        bpy.ops.wm.open_mainfile(filepath=saved)
        obj = bpy.data.objects[name]
        bpy.context.view_layer.objects.active = obj
        mesh = json.loads(obj.knead.session.splitlines()[1])["mesh"]
        self.assertEqual(mesh, os.path.join(self.folder, "saved", "knead_stamps", os.path.basename(path)))
        bpy.ops.knead.session_rebuild()
        self.same(self.vertices(obj), after)

    def test_a_stamp_and_its_mirror_image(self):
        from knead_blender import stamps

        obj = make_hand()
        before = self.vertices(obj)
        tip = tip_of(self, obj)
        path, _ = stamps.make(bpy.context.scene.knead, obj)
        pose = json.dumps((np.eye(3) * 0.05).tolist())
        way = json.dumps([[tip[0], tip[1] + 0.08, tip[2]], [tip[0], tip[1] + 0.02, tip[2]]])
        bpy.ops.knead.stamp(mesh=path, pose=pose, path=way, mirror={"X"})
        (line,) = (json.loads(line) for line in obj.knead.session.splitlines()[1:])
        self.assertEqual((line["mirror"], line["mesh"]), ("x", path))
        self.beside_the_command(obj, before)


run(Tools)
