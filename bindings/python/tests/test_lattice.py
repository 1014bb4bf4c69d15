"""Lattices from arrays: against a plain evaluation in numpy, their derivatives, and files of PyGeM."""

from math import comb

import numpy as np
import pytest

import knead


def bernstein(points, box, counts):
    """Returns the weights of all control points, an array (n, nx, ny, nz)."""
    axes = np.array(box.get("axes", np.eye(3)))
    u = (points - box["origin"]) @ axes.T / box["lengths"]
    w = [np.array([comb(n - 1, i) * u[:, a] ** i * (1 - u[:, a]) ** (n - 1 - i) for i in range(n)]) for a, n in enumerate(counts)]
    return np.einsum("in,jn,kn->nijk", *w)


def turned_box(random, counts):
    axes = np.linalg.qr(random.normal(size=(3, 3)))[0]
    lengths = random.uniform(1, 3, 3)
    origin = random.normal(size=3)
    points = origin + random.uniform(0, 1, (60, 3)) * lengths @ axes
    return {"origin": origin, "axes": axes, "lengths": lengths}, points


@pytest.mark.parametrize("counts", [(2, 2, 2), (3, 7, 2), (5, 4, 6), (7, 2, 3)])
def test_a_spline_is_the_plain_sum(counts):
    random = np.random.default_rng(sum(counts))
    box, points = turned_box(random, counts)
    displacements = random.normal(scale=0.02, size=(*counts, 3))
    stroke = knead.Lattice(**box, displacements=displacements, mode="spline")
    assert stroke.counts == list(counts) and np.array_equal(np.reshape(stroke.displacements, (*counts, 3)), displacements)
    moved = knead.deform(points, stroke)
    assert np.abs(moved - points - np.einsum("nijk,ijkc->nc", bernstein(points, box, counts), displacements)).max() < 1e-13
    back = knead.Flow(knead.Session([stroke])).inverse()(moved)
    assert np.abs(back - points).max() < 1e-12


def test_derivatives_are_those_of_differences():
    random = np.random.default_rng(3)
    counts = (3, 4, 2)
    box, points = turned_box(random, counts)
    displacements = random.normal(scale=0.02, size=(*counts, 3))
    stroke = knead.Lattice(**box, displacements=displacements, mode="spline")
    direction = random.normal(size=(*counts, 3))
    flow = knead.Flow(stroke)
    moved, tangents = flow.jvp(points, [direction])
    assert np.array_equal(moved, knead.deform(points, stroke, precision="float64"))
    step = 1e-5
    sides = [knead.deform(points, stroke.replace(displacements=displacements + s * step * direction)) for s in (1, -1)]
    assert np.abs((sides[0] - sides[1]) / (2 * step) - tangents).max() < 1e-9
    gradient = random.normal(size=points.shape)
    (slopes,) = flow.vjp(points, gradient)[1]
    assert slopes.shape == (*counts, 3)
    assert np.abs(slopes - np.einsum("nijk,nc->ijkc", bernstein(points, box, counts), gradient)).max() < 1e-10
    with pytest.raises(knead.InvalidInput, match="surface"):
        knead.Flow(stroke.replace(mode="volume"))
    with pytest.raises(knead.InvalidInput, match="direction"):
        flow.jvp(points, [direction[:2]])


def test_a_grid_has_derivatives_by_all_its_coefficients():
    random = np.random.default_rng(5)
    points = random.uniform(-0.5, 0.5, (30, 3))
    begin, end = random.normal(scale=0.02, size=(2, 4, 5, 3, 3))
    pull = knead.Implicit(path=[[0, 0, 0], [0.1, 0.2, 0]], inner=0.1, outer=0.6)
    gradient = random.normal(size=points.shape)

    def flow(first, last):
        grid = knead.Grid(origin=[-0.4, -0.8, -0.6], spacing=0.4, counts=[3, 5, 4], coefficients=first, end_coefficients=last)
        return knead.Flow([pull, grid])

    of_points, (none, slopes) = flow(begin, end).vjp(points, gradient)
    assert none is None and slopes.shape == (2, 4, 5, 3, 3) and of_points.shape == points.shape
    direction = random.normal(size=slopes.shape)
    step = 1e-4
    options = {"precision": "float64", "relative_tolerance": 1e-12}
    sides = [flow(begin + s * step * direction[0], end + s * step * direction[1])(points, **options) for s in (1, -1)]
    tangents = (sides[0] - sides[1]) / (2 * step)
    assert np.abs(flow(begin, end).jvp(points, [None, direction])[1] - tangents).max() < 1e-6 * np.abs(tangents).max()
    assert abs(np.sum(gradient * tangents) - np.sum(slopes * direction)) < 1e-6 * np.abs(gradient * tangents).sum()


def test_linear_displacements_move_the_box_linearly():
    random = np.random.default_rng(4)
    box, points = turned_box(random, (6, 5, 7))
    matrix = np.eye(3) + random.normal(scale=0.1, size=(3, 3))
    for degree in (0, 2, 3):
        empty = knead.Lattice(**box, displacements=np.zeros((6, 5, 7, 3)), mode="spline", degree=degree)
        places = knead.lattice_points(empty)
        moved = knead.deform(points, empty.replace(displacements=places @ matrix.T - places))
        assert np.abs(moved - points @ matrix.T).max() < 1e-12


def test_a_volume_lattice_keeps_the_volume(sphere):
    displacements = np.zeros((5, 5, 5, 3))
    displacements[2, 2, 2] = [0.3, 0.2, 0.4]
    stroke = knead.Lattice(origin=[-1.5] * 3, lengths=[3] * 3, displacements=displacements)
    assert stroke.mode == "volume"
    moved = knead.deform(sphere.vertices, stroke, sphere.faces)
    volume = knead.check(sphere.vertices, sphere.faces)["volume"]
    assert abs(knead.check(moved, sphere.faces)["volume"] / volume - 1) < 1e-4
    assert np.abs(moved - sphere.vertices).max() > 0.002


def test_a_fold_is_refused(sphere):
    displacements = np.zeros((2, 3, 3, 3))
    displacements[1, :, :, 0] = -2.5
    box = knead.Lattice(origin=[-1.2] * 3, lengths=[2.4] * 3, displacements=displacements, mode="spline")
    with pytest.raises(knead.InvalidInput, match=r'"displacements" fold the box at .*; 0\.9\d of them do not'):
        knead.deform(sphere.vertices, box, sphere.faces)


def test_files_of_pygem(tmp_path, sphere):
    lines = ["[Box info]", "# a comment"]
    for name, values in {"n control points": (2, 3, 2), "box length": (3, 3, 3), "box origin": (-1.5, -1.5, -1.5), "rotation angle": (0, 0, 0)}.items():
        lines += [f"{name} {axis}: {value}" for axis, value in zip("xyz", values)]
    lines += ["[Parameters weights]", "parameter x: 1 1 1 0.2", "", "parameter y: 0 0 0 0.0", "parameter z: 0 1 0 0.1", "             1 2 1 -0.1"]
    (tmp_path / "box.prm").write_text("\n".join(lines))
    moved = knead.deform(sphere.vertices, knead.Lattice(file=str(tmp_path / "box.prm"), mode="spline"), sphere.faces)
    weights = bernstein(sphere.vertices, {"origin": [-1.5] * 3, "lengths": [3] * 3}, (2, 3, 2))
    by = np.stack([weights[:, 1, 1, 1] * 0.6, 0 * weights[:, 0, 0, 0], weights[:, 0, 1, 0] * 0.3 - weights[:, 1, 2, 1] * 0.3], axis=1)
    assert np.abs(moved - sphere.vertices - by).max() < 1e-13
