"""The strokes Pose and Grid: arrays as input, and what they do."""

import base64

import numpy as np
import pytest
from conftest import bits, run

import knead

ACCURATE = {"relative_tolerance": 1e-11, "precision": "float64"}


@pytest.fixture(scope="module")
def cylinder(tmp_path_factory):
    path = tmp_path_factory.mktemp("pose") / "cylinder.ply"
    run("make", "cylinder", "-n", 1500, "-o", path, "-q")
    return knead.read(path)


def ends(vertices):
    """Masks of both ends along the longest side, and that side."""
    long = int(np.ptp(vertices, axis=0).argmax())
    low, high = vertices[:, long].min(), vertices[:, long].max()
    return vertices[:, long] < low + 0.15 * (high - low), vertices[:, long] > high - 0.15 * (high - low), long


@pytest.fixture(scope="module")
def bent(cylinder):
    """One end is held, the other turned by 40 degrees."""
    v = cylinder.vertices
    low, high, long = ends(v)
    axis = np.eye(3)[(long + 1) % 3]
    turned = {"vertices": np.flatnonzero(high), "rotate": axis, "center": v.mean(0), "angle_deg": 40}
    return knead.Pose(detail=0.1, parts=[{"vertices": low, "hold": True}, turned])


def test_masks_and_numbers_become_ranges():
    mask = np.array([True, True, False, True])
    ways = [mask, mask.tolist(), [0, 1, 3], np.array([3, 1, 0, 1]), {0, 1, 3}, [[0, 1], 3], np.array([[0, 1], [3, 3]])]
    poses = [knead.Pose(parts=[{"vertices": way, "translate": [0, 0, 1]}]) for way in ways]
    assert poses[0].to_dict()["parts"][0]["vertices"] in ([[0, 1], 3], [[0, 1], [3, 3]])
    for way, pose in zip(ways, poses):
        if way is not ways[2]:
            assert pose == poses[0], way
    assert knead.Pose(parts=[{"vertices": range(2, 7), "translate": [0, 0, 1]}]).parts[0]["vertices"] == [[2, 6]]


def test_arrays_of_places():
    path = np.array([[0, 1, 0], [0.5, 1, 0]])
    pins = [{"pin": np.int64(4), "path": path, "size": np.float64(0.05)}, {"pin_point": path[0], "hold": np.bool_(True)}]
    pose = knead.Pose(parts=pins, stiffness=[{"vertices": np.arange(3), "value": 5}])
    plain = [{"pin": 4, "path": path.tolist(), "size": 0.05}, {"pin_point": [0, 1, 0], "hold": True}]
    assert pose == knead.Pose(parts=plain, stiffness=[{"vertices": [[0, 2]], "value": 5}])
    assert pose == knead.stroke({"tool": "pose", "parts": pins, "stiffness": [{"vertices": np.arange(3), "value": 5}]})


def test_a_pose_is_a_value(bent):
    held = knead.Pose(parts=[{"pin": 1, "hold": True, "turn": None}, {"points": np.eye(3), "translate": [0, 0, 1]}])
    for pose in (bent, held):
        assert eval(repr(pose), {"knead": knead}) == pose
        assert knead.stroke(pose.to_dict()) == pose
        assert knead.Session.parse(knead.Session(pose).text())[0] == pose
    assert held.detail == 0 and held.tolerance == 0.005 and held.exact is False and bent.replace(detail=0.2).detail == 0.2


def test_a_pose_moves_its_parts_rigidly(cylinder, bent):
    v = cylinder.vertices
    size = np.linalg.norm(np.ptp(v, axis=0))
    low, high, long = ends(v)
    moved = knead.deform(v, bent, cylinder.faces)
    axis, center = np.eye(3)[(long + 1) % 3], v.mean(0)
    r, angle = v[high] - center, np.radians(40)
    turned = r * np.cos(angle) + np.cross(axis, r) * np.sin(angle) + np.outer(r @ axis, axis) * (1 - np.cos(angle))
    off = np.linalg.norm(moved[high] - (center + turned), axis=1) / size
    assert np.sqrt(np.mean(off**2)) < 2e-3 and off.max() < 2e-2
    assert np.abs(moved[low] - v[low]).max() < 2e-3 * size
    assert abs(knead.check(moved, cylinder.faces)["volume"] / knead.check(v, cylinder.faces)["volume"] - 1) < 1e-3


def test_resolving_gives_grids_with_equal_bits(cylinder, bent, tmp_path):
    v, faces = cylinder.vertices, cylinder.faces
    moved = knead.deform(v, bent, faces)
    resolved = knead.Session(bent).resolve(v, faces)
    assert len(resolved) > 1 and all(isinstance(stroke, knead.Grid) for stroke in resolved)
    assert bits(knead.deform(v, resolved)) == bits(moved)
    resolved.write(tmp_path / "grids.knead")
    assert bits(knead.deform(v, knead.Session.read(tmp_path / "grids.knead"))) == bits(moved)
    assert bits(knead.deform(v, bent, faces, threads=1)) == bits(moved)
    cylinder.write(tmp_path / "before.ply", double=True)
    knead.Session(bent).write(tmp_path / "pose.knead")
    run("deform", tmp_path / "before.ply", tmp_path / "pose.knead", "-q", "-o", tmp_path / "after.ply")
    assert bits(knead.read(tmp_path / "after.ply").vertices.astype(np.float32)) == bits(moved.astype(np.float32))


def test_the_inverse_restores(cylinder, bent):
    v = cylinder.vertices
    size = np.linalg.norm(np.ptp(v, axis=0))
    resolved = knead.Session(bent).resolve(v, cylinder.faces)
    moved = knead.deform(v, resolved, **ACCURATE)
    assert np.abs(moved - v).max() > 0.05 * size
    back = knead.deform(moved, resolved, inverse=True, diagonal=size, **ACCURATE)
    assert np.abs(back - v).max() < 1e-8 * size


def test_grids_take_arrays(cylinder, bent):
    grid = knead.Session(bent).resolve(cylinder.vertices, cylinder.faces)[0]
    nodes = np.frombuffer(base64.b64decode(grid.coefficients)).reshape(*grid.counts[::-1], 3)
    assert grid.replace(coefficients=nodes) == grid
    assert grid.replace(coefficients=nodes.reshape(-1, 3)) == grid
    half, x = grid.replace(coefficients=0.5 * nodes), cylinder.vertices[::50]
    whole_flow, half_flow = knead.Flow(grid), knead.Flow(half)
    assert np.abs(half_flow.velocity(x, 0.5) - 0.5 * whole_flow.velocity(x, 0.5)).max() < 1e-12
    assert np.abs(np.linalg.det(whole_flow.jacobian(x, **ACCURATE)) - 1).max() < 1e-9


MOVES = {"translate": [0, 0, 1]}


@pytest.mark.parametrize(
    "parts, words",
    [
        ([], "1 or more|parts"),
        ([{"vertices": np.array([], int), **MOVES}], "1 or more vertices"),
        ([{"vertices": np.zeros(9, bool), **MOVES}], "1 or more vertices"),
        ([{"vertices": np.array([0.5]), **MOVES}], "vertices"),
        ([{"vertices": np.array([-1, 3]), **MOVES}], "from 0 on"),
        ([{"vertices": [1], **MOVES}, {"vertices": np.arange(3), "hold": True}], "vertex 1 is in part"),
        ([{"vertices": [1], "hold": True}], "none of the parts"),
        ([{"vertices": [1], "hold": True, **MOVES}], "holds and moves"),
        ([{"pin": 1, "to": [0, np.nan, 0]}], "parts"),
        ([{"pin": 1, "to": [0, 0, 0], "colour": "red"}], "colour"),
        ([{"pin": i, "to": [0, 0, 0]} for i in range(1001)], "at most 1000"),
    ],
)
def test_wrong_parts(parts, words):
    with pytest.raises(knead.InvalidInput, match=words) as caught:
        knead.Pose(parts=parts)
    assert "\n" not in str(caught.value)


def test_a_vertex_that_the_shape_lacks(cylinder):
    v = cylinder.vertices
    with pytest.raises(knead.InvalidInput, match=f"vertex {len(v)}.*shape has {len(v)}"):
        knead.deform(v, knead.Pose(parts=[{"pin": len(v), "to": [0, 0, 0]}]), cylinder.faces)
    with pytest.raises(knead.InvalidInput, match="faces"):
        knead.deform(v, knead.Pose(parts=[{"pin": 0, "to": [0, 0, 0]}]))
