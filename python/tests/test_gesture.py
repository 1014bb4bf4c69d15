"""From a pointer to strokes: Surface, PaintDrag, symmetric."""

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


def test_images_keep_the_symmetry(sphere):
    pull = knead.Implicit(path=[[0.7, 0.7, 0], [0.8, 0.9, 0], [0.8, 1, 0.2]], inner=0.1, outer=0.5)
    both = knead.symmetric(pull, "x")
    assert len(both) == 4 and both[0].path[0][0] == -both[1].path[0][0]
    flipped = sphere.vertices * [-1, 1, 1]
    moved, image = knead.deform(sphere.vertices, both), knead.deform(flipped, both) * [-1, 1, 1]
    assert np.abs(moved - image).max() < 1e-4 < np.abs(moved - sphere.vertices).max()
    on_plane = knead.Rotate(center=[0, 1, 0], axis=[1, 0, 0], angle_deg=20, inner=0.1, outer=0.5)
    along = knead.Stretch(center=[0, 1, 0], axis=[1, 0, 0], factor=1.5, inner=0.1, outer=0.5)
    for its_own_image in (on_plane, along):
        assert knead.symmetric([its_own_image], "x") == [its_own_image]
    assert len(knead.symmetric([pull], "xyz")) == 4 + 8  # the first piece lies in z = 0


def test_the_image_of_a_stamp_names_its_file():
    stamp = knead.Stamp(mesh="foot.ply", path=[[1, 0, 0], [0.8, 0, 0]])
    with pytest.raises(knead.InvalidInput, match="image_file"):
        knead.symmetric([stamp], "x")
    images = knead.symmetric([stamp], "x", image_file=lambda path, planes: f"{planes}_{path}")
    assert [s.mesh for s in images] == ["foot.ply", "x_foot.ply"]
