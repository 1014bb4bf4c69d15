"""From a pointer to strokes: Surface, PaintDrag, brushes, symmetric."""

import numpy as np
import pytest
from conftest import bits

import knead


@pytest.fixture(scope="module")
def surface(sphere):
    return knead.Surface(sphere.vertices, sphere.faces)


def test_a_ray_meets_a_sphere(surface):
    for direction in np.random.default_rng(1).normal(size=(50, 3)):
        unit = direction / np.linalg.norm(direction)
        point, normal = surface.hit(5 * unit, -direction)
        assert np.linalg.norm(np.subtract(point, unit)) < 2e-3
        assert np.dot(normal, unit) > 0.999
        assert np.linalg.norm(surface.middle(5 * unit, -direction)) < 2e-3
        assert abs(surface.thickness(point, normal) - 2) < 0.01
        ring = surface.ring(point, normal, 0.3)
        assert ring.shape == (64, 3)
        assert np.abs(np.linalg.norm(ring - point, axis=1) - 0.3).max() < 0.03
    assert surface.hit([5, 0, 0], [1, 0, 0]) is None and surface.middle([5, 0, 0], [1, 0, 0]) is None


def test_a_moved_surface_is_like_a_new_one(sphere, hand):
    moved = sphere.vertices * [1.5, 1, 0.5] + 0.1
    surface, new = knead.Surface(sphere.vertices, sphere.faces), knead.Surface(moved, sphere.faces)
    surface.move(moved)
    for origin in np.random.default_rng(2).normal(size=(50, 3)):
        ray = 5 * origin, 0.1 - 5 * origin
        assert surface.hit(*ray) == new.hit(*ray) and surface.middle(*ray) == new.middle(*ray)
    with pytest.raises(knead.InvalidInput, match="as before"):
        surface.move(hand.vertices)


def test_refusals(surface):
    with pytest.raises(knead.InvalidInput, match="direction"):
        surface.hit([0, 0, 5], [0, 0, 0])
    with pytest.raises(knead.InvalidInput, match="finite"):
        surface.hit([0, float("nan"), 5], [0, 0, 1])
    with pytest.raises(knead.InvalidInput, match="depth|outer"):
        knead.PaintDrag(outer=-1, depth=0.1)
    with pytest.raises(knead.InvalidInput, match="planes"):
        knead.symmetric([], "w")


def test_a_part_bends_alone(hand):
    tip = hand.vertices[hand.vertices[:, 1].argmax()]
    surface = knead.Surface(hand.vertices, hand.faces)
    below = tip - [0, 0.25, 0]
    place = surface.part(surface.middle(below + [0, 0, 5], [0, 0, -1]), [0, 1, 0], axis=[1, 0, 0], angle_deg=60)
    bend = knead.Bend(axis=[1, 0, 0], angle_deg=60, **place)
    moved = (knead.deform(hand.vertices, bend, hand.faces) != hand.vertices).any(axis=1)
    assert 0 < moved.sum() < len(moved) / 4
    assert (np.linalg.norm((hand.vertices[moved] - tip)[:, [0, 2]], axis=1) < 0.5).all()
    wide = surface.with_safe_zone(bend.replace(angle_deg=150))
    assert wide.outer - wide.inner >= bend.outer - bend.inner


def places(surface, count):
    for angle in np.linspace(-0.6, 0.6, count):
        yield surface.hit([5 * np.sin(angle), 0, 5 * np.cos(angle)], [-np.sin(angle), 0, -np.cos(angle)])


def test_paint_does_not_depend_on_the_speed(sphere, surface):
    results = []
    for count in (200, 400):
        drag = knead.PaintDrag(outer=0.3, depth=-0.05)
        assert drag.strokes == []
        for point, normal in places(surface, count):
            drag.touch(point, normal)
        drag.finish()
        results.append(knead.deform(sphere.vertices, drag.strokes, sphere.faces))
    assert np.abs(results[0] - results[1]).max() < 0.01
    height = np.linalg.norm(results[0], axis=1).max() - 1
    assert 0.03 < height < 0.07


def test_paint_is_extended_live(sphere, surface):
    drag, bench = knead.PaintDrag(outer=0.3, depth=0.05), knead.Workbench(sphere.vertices, sphere.faces)
    for point, normal in places(surface, 60):
        drag.touch(point, normal, pressure=0.5)
        bench.set_live(drag.strokes)
    bench.finish()
    assert bits(bench.vertices) == bits(knead.deform(sphere.vertices, drag.strokes, sphere.faces))
    assert np.linalg.norm(bench.vertices, axis=1).min() < 0.99


def test_brushes_go_either_way_whatever_the_size(sphere):
    heights = {}
    for size in (1e-3, 1, 1e3):
        vertices = sphere.vertices * size
        for name in ("move", "snakehook", "paint", "crease", "pinch", "flatten"):
            pulls = name in ("move", "snakehook")
            path = [[0, 0, size], [0, 0.1 * size, 1.3 * size]] if pulls else [[0, -0.3 * size, 0.95 * size], [0, 0.3 * size, 0.95 * size]]
            for sign in (1,) if pulls else (1, -1):
                amount = None if sign == 1 else -0.15 if name == "paint" else -0.7
                made = knead.brush(name, path, radius=0.2 * size, amount=amount)
                assert made.tool == ("implicit" if pulls else "paint") and made.falloff == "wide"
                moved = knead.deform(vertices, made, sphere.faces)
                far = np.linalg.norm(moved, axis=1) / size - 1
                heights.setdefault((name, sign), []).append((far.min(), far.max()))
    for lows in heights.values():
        assert np.ptp(lows, axis=0).max() < 1e-3  # the same at every size
    low, high = (dict((key, value[0][i]) for key, value in heights.items()) for i in (0, 1))
    assert high["move", 1] > 0.2 and low["move", 1] > -0.03
    assert high["paint", 1] > 0.015 and low["paint", -1] < -0.015
    assert low["crease", 1] < -0.02 and high["crease", -1] > 0.02
    assert low["flatten", 1] < -1e-3
    with pytest.raises(knead.InvalidInput, match="move, snakehook, paint, crease"):
        knead.brush("clay", [[0, 0, 1]], radius=0.1)


def test_flattening_draws_to_the_mean_plane(sphere):
    """On a shape with a bump the plane under the brush lies below the place that is touched."""
    bumpy = knead.deform(sphere.vertices, knead.brush("move", [[0, 0, 1], [0, 0, 1.05]], radius=0.05), sphere.faces)
    surface = knead.Surface(bumpy, sphere.faces)
    heights = []
    for mean in (surface, None):
        drag = knead.PaintDrag(outer=0.2, depth=0, falloff="wide", pinch=-1, surface=mean)
        drag.touch(*surface.hit([0, 0, 5], [0, 0, -1]))
        drag.finish()
        heights.append(knead.deform(bumpy, drag.strokes)[:, 2].max())
    assert heights[0] < bumpy[:, 2].max() - 0.02
    assert heights[0] < heights[1] - 0.01


def test_images_keep_the_symmetry(sphere):
    pull = knead.Implicit(path=[[0.7, 0.7, 0], [0.8, 0.9, 0], [0.8, 1, 0.2]], inner=0.1, outer=0.5)
    (both,) = knead.symmetric(pull, "x")
    assert both.mirror == "x" and both == pull.replace(mirror="x")
    flipped = sphere.vertices * [-1, 1, 1]
    options = {"precision": "float64", "diagonal": 3}
    moved, image = knead.deform(sphere.vertices, both, **options), knead.deform(flipped, both, **options) * [-1, 1, 1]
    assert np.abs(moved - image).max() < 1e-12
    assert np.abs(moved - sphere.vertices).max() > 0.1
    on_plane = knead.Rotate(center=[0, 1, 0], axis=[1, 0, 0], angle_deg=20, inner=0.1, outer=0.5)
    along = knead.Stretch(center=[0, 1, 0], axis=[1, 0, 0], factor=1.5, inner=0.1, outer=0.5)
    for its_own_image in (on_plane, along):
        assert knead.symmetric([its_own_image], "x") == [its_own_image]
    assert knead.symmetric(both, "zx")[0].mirror == "xz"
    relax = knead.Relax(points=[[0.5, 0, 0]], radius=0.3)
    assert knead.symmetric(relax, "x")[0].points == [[0.5, 0, 0], [-0.5, 0, 0]]


@pytest.mark.parametrize("precision", ["float32", "float64"])
def test_points_of_a_mirror_plane_stay_in_it(precision):
    y, z = np.meshgrid(np.linspace(-1, 1, 21), np.linspace(0, 1.6, 17))
    plane = np.c_[np.full(y.size, 0.1), y.ravel(), z.ravel()]
    mirror = {"normal": [1, 0, 0], "point": [0.1, 0, 0]}
    for stroke in (
        knead.Implicit(path=[[0.3, 0, 0.9], [0.5, 0, 1.3]], inner=0.15, outer=0.7, mirror=mirror),
        knead.Rotate(center=[0.3, 0, 0.8], axis=[0, 0, 1], angle_deg=90, inner=0.2, outer=0.8, mirror=mirror),
        knead.Pins(points=[[0.3, 0, 0.8]], to=[[0.5, 0.1, 1.0]], radius=0.9, mirror=mirror),
    ):
        moved = knead.deform(plane, stroke, diagonal=2, precision=precision)
        assert (moved[:, 0] == 0.1).all() and np.abs(moved - plane).max() > 0.01


def test_mirrors_that_are_refused():
    pull = {"path": [[0.3, 0, 0.9], [0.5, 0, 1.3]], "inner": 0.15, "outer": 0.7}
    for mirror in ("w", "", [], {"point": [0, 0, 0]}, {"normal": [0, 0, 0]}, [{"normal": [1, 0, 0]}] * 2, 1, {"axis": "x"}):
        with pytest.raises(knead.InvalidInput, match="mirror"):
            knead.Implicit(**pull, mirror=mirror)
    with pytest.raises(knead.InvalidInput):
        knead.Relax(points=[[0.5, 0, 0]], radius=0.3, mirror="x")


def test_the_image_of_a_stamp_needs_no_file():
    stamp = knead.Stamp(mesh="foot.ply", path=[[1, 0, 0], [0.8, 0, 0]])
    assert knead.symmetric([stamp], "x") == [stamp.replace(mirror="x")]
