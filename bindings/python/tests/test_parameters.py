"""Parameters of sessions, and derivatives with respect to them."""

import copy
import pickle
import subprocess

import numpy as np
import pytest
from conftest import COMMAND, bits, run

import knead

PULL = {"tool": "implicit", "path": [[0, 1, 0], [0, "$length", 0.3]], "inner": 0.1, "outer": 0.6}
TURN = {"tool": "rotate", "center": [0, 0.9, 0], "axis": [0, 0, 1], "angle_deg": "$angle", "inner": 0.2, "outer": 0.8}
BEND = {"tool": "bend", "center": [0, 0, 0], "axis": [0, 1, 0], "normal": [0, 0, -1], "width": 1, "angle_deg": "$angle"}
BOUNDED = {"length": 1.3, "angle": (30, 0, 90)}


@pytest.fixture
def named():
    return knead.Session([PULL, TURN], parameters=BOUNDED)


def plain(length, angle):
    return knead.Session([{**PULL, "path": [[0, 1, 0], [0, length, 0.3]]}, {**TURN, "angle_deg": angle}])


def test_they_have_values_and_bounds(named):
    assert named.parameters == {"length": 1.3, "angle": 30}
    assert named.bounds == {"length": (None, None), "angle": (0, 90)}
    assert named[0].path[1] == [0, 1.3, 0.3] and named[1].angle_deg == 30
    assert knead.Session([knead.Implicit(path=[[0, 1, 0], [0, 2, 0]], inner=0.1, outer=0.6)]).parameters == {}
    assert knead.Session(parameters={"a": (1, None, 2)}).bounds == {"a": (None, 2)}


def test_a_call_gives_other_values(named, sphere):
    changed = named(length=1.4, angle=np.float32(12))
    assert named.parameters["length"] == 1.3 and changed.parameters == {"length": 1.4, "angle": 12}
    assert bits(knead.deform(sphere.vertices, changed)) == bits(knead.deform(sphere.vertices, plain(1.4, 12)))
    assert changed(length=1.3, angle=30) == named
    assert named() == named


def test_files_keep_them(named, tmp_path):
    changed = named(angle=45)
    changed.write(tmp_path / "a.knead")
    again = knead.Session.read(tmp_path / "a.knead")
    assert again == changed and again.parameters == changed.parameters and again.bounds == changed.bounds
    assert '"$angle"' in (tmp_path / "a.knead").read_text()
    assert again(angle=30)[1].angle_deg == 30
    assert "$" not in plain(1, 2).text()


@pytest.mark.parametrize("way", [copy.copy, copy.deepcopy, lambda thing: pickle.loads(pickle.dumps(thing))])
def test_copies_keep_them(named, way):
    again = way(named)
    assert again == named and again(length=2) == named(length=2)


def test_lists_of_strokes_keep_them(named):
    assert named[:1](length=2)[0].path[1] == [0, 2, 0.3]
    named.append(BEND)
    named[0] = {**PULL, "outer": "$length"}
    assert named(length=1.1, angle=50)[2].angle_deg == 50
    assert named(length=1.1)[0].outer == 1.1


def message(call):
    with pytest.raises(knead.InvalidInput) as raised:
        call()
    return str(raised.value)


def test_errors_are_those_of_the_command(named, files, sphere):
    path = files / "named.knead"
    named.write(path)
    session = knead.Session.read(path)
    for text, values in [("angle=91", {"angle": 91}), ("wide=1", {"wide": 1}), ("length=nan", {"length": np.nan})]:
        words = [COMMAND, "deform", files / "sphere.ply", path, "-o", files / "out.ply", "--set", text]
        done = subprocess.run([*map(str, words)], capture_output=True, text=True)
        assert done.returncode == 3
        assert done.stderr == f"knead: {message(lambda values=values: session(**values))}\n"
    assert message(lambda: session(angle=91)) == f'{path}: parameter "angle" must be from 0 to 90, got 91'
    assert "no parameter \"wide\"" in message(lambda: knead.Session({**TURN, "inner": "$wide"}, parameters=BOUNDED))
    assert "the session has none" in message(lambda: knead.stroke(TURN))
    for wrong in ({"2": 1}, {"a": (3, 4, 5)}, {"a": np.nan}, {"a": "1"}, {"a": (1, 2, 0)}, {"a": None}):
        message(lambda wrong=wrong: knead.Session(parameters=wrong))
    with pytest.raises((TypeError, ValueError)):
        knead.Session(parameters={"a": (1, 2)})
    with pytest.raises((TypeError, ValueError)):
        named(length="long")


def test_the_command_sets_the_same(named, files, sphere):
    named.write(files / "set.knead")
    run("deform", files / "sphere.ply", files / "set.knead", "-q", "--set", "length=1.5", "-o", files / "set.ply")
    shape = knead.read(files / "sphere.ply")
    shape.vertices = knead.deform(shape.vertices, named(length=1.5))
    shape.write(files / "ours.ply")
    assert (files / "ours.ply").read_bytes() == (files / "set.ply").read_bytes()


# --- derivatives

RANDOM = np.random.default_rng(47)
POINTS = RANDOM.uniform(-0.9, 0.9, (200, 3)) + [0, 0.4, 0]


def exact(session):
    return knead.deform(POINTS, session, precision="float64", relative_tolerance=1e-13, diagonal=1)


def difference(session, name, h):
    """Central differences, extrapolated twice."""
    value = session.parameters[name]
    steps = [(exact(session(**{name: value + h / 2**k})) - exact(session(**{name: value - h / 2**k}))) / (h / 2 ** (k - 1)) for k in range(3)]
    once = [(4 * b - a) / 3 for a, b in zip(steps, steps[1:])]
    return (16 * once[1] - once[0]) / 15


@pytest.mark.parametrize("name, h", [("length", 1e-3), ("angle", 3e-2)])
def test_forwards_as_differences(named, name, h):
    moved, tangents = named.jvp(POINTS, {name: 1}, diagonal=1)
    assert np.abs(moved - exact(named)).max() < 1e-9
    expected = difference(named, name, h)
    assert np.abs(tangents - expected).max() < 1e-8 * np.abs(expected).max()
    assert np.abs(expected).max() > 1e-3


def test_backwards_as_forwards(named):
    gradient = RANDOM.normal(size=POINTS.shape)
    found = named.vjp(POINTS, gradient)
    assert list(found) == ["length", "angle"]
    for name, number in found.items():
        assert number == pytest.approx((gradient * named.jvp(POINTS, {name: 1})[1]).sum(), rel=1e-7)
    both = named.jvp(POINTS, [2, -0.5])[1]
    assert (gradient * both).sum() == pytest.approx(2 * found["length"] - 0.5 * found["angle"], rel=1e-7)


def test_backwards_to_the_points(named):
    gradient = RANDOM.normal(size=POINTS.shape)
    of_points, of_parameters = named.vjp(POINTS, gradient, of_points=True)
    assert of_parameters == named.vjp(POINTS, gradient)
    jacobian = knead.Flow(named).jacobian(POINTS, precision="float64", relative_tolerance=1e-11)
    assert np.abs(of_points - np.einsum("nij,ni->nj", jacobian, gradient)).max() < 1e-7


def test_gauss_newton_finds_the_angle_of_a_bend():
    bar = knead.Session(BEND, parameters={"angle": (30, 0, 170)})
    wanted = knead.deform(POINTS, bar(angle=72), precision="float64", relative_tolerance=1e-10)
    angle, angles = 30.0, []
    for _ in range(5):
        moved, tangents = bar(angle=angle).jvp(POINTS, {"angle": 1})
        angle += ((wanted - moved) * tangents).sum() / (tangents**2).sum()
        angles.append(angle)
    assert abs(angles[-1] - 72) < 1e-7
    assert abs(angles[0] - 72) > 1e-2  # it is not linear


def test_steps_along_the_gradient_make_a_sum_of_squares_smaller(named):
    wanted = exact(named(length=1.5, angle=55))
    now, losses = named, []
    for _ in range(12):
        moved, _ = now.jvp(POINTS, {})
        losses.append(((moved - wanted) ** 2).sum())
        slope = now.vjp(POINTS, 2 * (moved - wanted))
        columns = [now.jvp(POINTS, {name: 1})[1].ravel() for name in now.parameters]
        step = np.linalg.solve(np.array(columns) @ np.array(columns).T, [-0.5 * slope[name] for name in now.parameters])
        now = now(**{name: now.parameters[name] + s for name, s in zip(now.parameters, step)})
    assert losses == sorted(losses, reverse=True) or losses[-1] < 1e-12
    assert now.parameters == pytest.approx({"length": 1.5, "angle": 55}, abs=1e-6)


def test_wrong_derivatives_are_errors(named):
    assert message(lambda: named.jvp(POINTS, {"wide": 1})) == 'no parameter "wide"; the session has length, angle'
    message(lambda: named.jvp(POINTS, [1]))
    message(lambda: named.jvp(POINTS, [1, np.inf]))
    message(lambda: named.vjp(POINTS, POINTS[1:]))
    message(lambda: named.jvp(POINTS, [1, 1], relative_tolerance=-1))
    message(lambda: named.jvp(POINTS, [1, 1], diagonal=0))
    whole = knead.Session({**TURN, "angle_deg": 20, "falloff": "$n"}, parameters={"n": 4})
    assert 'no derivative with respect to "n"' in message(lambda: whole.vjp(POINTS, POINTS))


def test_progress_can_end_them(named):
    many = np.tile(POINTS, (500, 1))
    assert named.jvp(many, [1, 1], progress=lambda part: False) is None
    assert named.vjp(many, many, progress=lambda part: False) is None
