"""Measures of a surface against central differences, and the example that optimises under them."""

import runpy

import numpy as np
import pytest
from conftest import SOURCE

import knead


def torus(rows=14, columns=24, tube=0.4):
    u, v = np.meshgrid(np.arange(rows) * 2 * np.pi / rows, np.arange(columns) * 2 * np.pi / columns, indexing="ij")
    ring = 1 + tube * np.cos(u)
    points = np.column_stack([(ring * np.cos(v)).ravel(), (ring * np.sin(v)).ravel(), tube * np.sin(u).ravel()])
    at = lambda i, j: i % rows * columns + j % columns
    faces = [t for i in range(rows) for j in range(columns)
             for t in ([at(i, j), at(i, j + 1), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i + 1, j)])]
    return points + np.random.default_rng(3).normal(0, 0.01, points.shape), np.array(faces)


POINTS, FACES = torus()
AT = [0, 17, 101, 240]
PATCH = FACES[300:340]
MEASURES = {
    "volume": lambda p: knead.volume_of(p, FACES),
    "area": lambda p: knead.area_of(p, FACES),
    "thickness": lambda p: knead.thickness_at(p, AT, FACES),
    "curvature": lambda p: knead.curvature(p, AT, FACES),
    "distance": lambda p: knead.patch_distance(p, AT, PATCH),
}


@pytest.mark.parametrize("name", MEASURES)
def test_derivatives_are_those_of_differences(name):
    measure = MEASURES[name]
    here = measure(POINTS)
    for seed in range(10):
        random = np.random.default_rng(seed)
        tangents = random.normal(size=POINTS.shape)
        step = 1e-6
        expected = (measure(POINTS + step * tangents).values - measure(POINTS - step * tangents).values) / (2 * step)
        found = here.jvp(tangents)
        assert np.allclose(found, expected, rtol=1e-6, atol=1e-7 * np.abs(expected).max())
        weights = random.normal(size=len(here))
        assert np.isclose((here.vjp(weights) * tangents).sum(), found @ weights, rtol=1e-12, atol=1e-12)


def test_values_of_a_torus():
    plain = torus()[0]
    fine, faces = torus(80, 160)
    fine = fine - np.random.default_rng(3).normal(0, 0.01, fine.shape)
    assert float(knead.volume_of(fine, faces)) == pytest.approx(2 * np.pi**2 * 0.4**2, rel=3e-3)
    assert float(knead.area_of(fine, faces)) == pytest.approx(4 * np.pi**2 * 0.4, rel=3e-3)
    outside = [0]  # on the outer equator the radii are 0.4 and 1.4
    assert knead.curvature(fine, outside, faces).values[0] == pytest.approx((1 / 0.4 + 1 / 1.4) / 2, rel=1e-2)
    assert knead.thickness_at(fine, outside, faces).values[0] == pytest.approx(0.8, rel=1e-3)
    assert len(knead.patch_distance(plain, np.arange(len(plain)) < 5, PATCH)) == 5


def test_bad_input_is_one_clear_line():
    with pytest.raises(knead.InvalidInput, match="the surface is open, .* of the vertices"):
        knead.volume_of(POINTS, FACES[1:])
    with pytest.raises(knead.InvalidInput, match="lies at a border"):
        knead.curvature(POINTS, [int(FACES[0][0])], FACES[1:])
    with pytest.raises(knead.InvalidInput, match="there is no other side"):
        knead.thickness_at([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [0], [[0, 1, 2]])
    for at in ([len(POINTS)], [-1]):
        with pytest.raises(knead.InvalidInput, match="does not exist"):
            knead.thickness_at(POINTS, at, FACES)
    with pytest.raises(knead.InvalidInput, match="the patch has no faces"):
        knead.patch_distance(POINTS, [0], np.zeros((0, 3), int))
    with pytest.raises(knead.InvalidInput, match="weights must have a number for each of 1 values, got 2"):
        knead.volume_of(POINTS, FACES).vjp([1, 2])
    with pytest.raises(knead.InvalidInput, match="tangents must have"):
        knead.volume_of(POINTS, FACES).jvp(POINTS[1:])
    with pytest.raises(TypeError, match="the measure has 4 values"):
        float(knead.curvature(POINTS, AT, FACES))


def test_the_tank_holds_a_fifth_more(capsys):
    pytest.importorskip("scipy", reason="scipy's SLSQP optimises in the example")
    result = runpy.run_path(str(SOURCE / "examples/python/tank.py"))
    assert result["found"].success, result["found"].message
    assert abs(result["held"]) < 1e-6
    assert result["free"] > result["CLEARANCE"] - 1e-6
    assert "volume off by" in capsys.readouterr().out


def test_the_wing_gets_its_lift(capsys):
    pytest.importorskip("scipy", reason="scipy's SLSQP optimises in the example")
    result = runpy.run_path(str(SOURCE / "examples/python/wing.py"))
    found, start = result["found"], result["start"]
    assert found.success, found.message
    assert abs(result["lift"]["fun"](found.x) - result["LIFT"]) < 1e-6
    assert result["volume"]["fun"](found.x) > result["full"] * (1 - 1e-6)
    assert (result["thickness"]["fun"](found.x) > 0.99 * result["thick"] - 1e-6).all()
    assert found.fun < result["area"]["fun"](start)
    step = 1e-6 * np.random.default_rng(1).normal(size=start.shape)
    for name in ("area", "volume", "lift", "thickness"):
        fun, slopes = result[name]["fun"], result[name]["jac"](found.x)
        assert np.abs((fun(found.x + step) - fun(found.x - step)) / 2 - slopes @ step).max() < 1e-4 * np.abs(slopes @ step).max()
