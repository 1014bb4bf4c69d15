"""Everything that a caller can pass for points and faces: the right result, or a clear error."""

import gc

import numpy as np
import pytest
from conftest import bits

import knead


@pytest.fixture
def expected(sphere, pull):
    return knead.deform(sphere.vertices, pull)


@pytest.mark.parametrize(
    "change",
    [
        lambda v: v.tolist(),
        lambda v: np.asfortranarray(v),
        lambda v: np.repeat(v, 2, axis=0)[::2],
        lambda v: np.ascontiguousarray(v[::-1])[::-1],
        lambda v: np.hstack([v, v])[:, :3],
        lambda v: v.astype(v.dtype.newbyteorder()),
        lambda v: np.frombuffer(b"x" + v.tobytes(), dtype=np.uint8)[1:].view(np.float64).reshape(-1, 3),
        lambda v: type("Mesh", (), {"vertices": v})(),
        lambda v: type("Cloud", (), {"points": v})(),
        lambda v: v.astype(np.longdouble),
        lambda v: np.ma.masked_array(v),
        lambda v: memoryview(v),
    ],
)
def test_layouts(sphere, pull, expected, change):
    result = knead.deform(change(sphere.vertices.copy()), pull)
    assert result.dtype == np.float64 and bits(result) == bits(expected)


def test_read_only_input_is_not_changed(sphere, pull, expected):
    v = sphere.vertices.copy()
    v.flags.writeable = False
    assert bits(knead.deform(v, pull)) == bits(expected)
    with pytest.raises(knead.InvalidInput, match="read-only"):
        knead.deform(v, pull, out=v)


def test_float32_gives_float32(sphere, pull):
    v = sphere.vertices.astype(np.float32)
    result = knead.deform(v, pull)
    assert result.dtype == np.float32
    assert bits(result) == bits(knead.deform(v.astype(np.float64), pull).astype(np.float32))


@pytest.mark.parametrize("kind", [np.int8, np.uint16, np.int64, np.uint64])
def test_integers(kind, pull):
    v = np.array([[0, 1, 0], [1, 0, 0]], dtype=kind)
    result = knead.deform(v, pull)
    assert result.dtype == np.float64 and bits(result) == bits(knead.deform(v.astype(float), pull))


@pytest.mark.parametrize("empty", [np.zeros((0, 3)), [], np.zeros((0, 3), np.float32), ()])
def test_empty(empty, session):
    assert knead.deform(empty, session).shape == (0, 3)
    assert knead.Flow(session)(empty).shape == (0, 3)
    assert knead.Flow(session).jacobian(empty).shape == (0, 3, 3)
    assert knead.Flow(session).path(empty, 3).shape == (3, 0, 3)


@pytest.mark.parametrize(
    "wrong",
    [None, 3, "vertices", {"a": 1}, [["a", "b", "c"]], [[1j, 0, 0]], [[1, 2, 3], [4, 5]], [[None, 0, 0]], object(),
     np.zeros((2, 3), bool), np.array([["2020-01-01"] * 3], "datetime64[D]")],
)
def test_wrong_types(wrong, pull):
    with pytest.raises((TypeError, knead.InvalidInput)) as caught:
        knead.deform(wrong, pull)
    assert "vertices" in str(caught.value)


@pytest.mark.parametrize("shape", [(3,), (4, 2), (2, 3, 3), (3, 4), (0, 4)])
def test_wrong_shapes(shape, pull):
    with pytest.raises(knead.InvalidInput, match=r"\(n, 3\)"):
        knead.deform(np.zeros(shape), pull)


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_not_finite_are_named_by_their_first_index(sphere, session, value):
    v = sphere.vertices.copy()
    v[1234, 1] = v[3000, 2] = value
    with pytest.raises(knead.InvalidInput, match=r"vertices\[1234\]"):
        knead.deform(v, session)
    with pytest.raises(knead.InvalidInput, match=r"vertices\[1234\]"):
        knead.deform(v, session, sphere.faces)


def test_in_place(sphere, pull, expected):
    v = sphere.vertices.copy()
    address = v.ctypes.data
    result = knead.deform(v, pull, out=v)
    assert result is v and v.ctypes.data == address and bits(v) == bits(expected)


@pytest.mark.parametrize("kind", [np.float64, np.float32])
@pytest.mark.parametrize("order", ["C", "F"])
def test_out(sphere, pull, expected, kind, order):
    v = sphere.vertices
    out = np.zeros(v.shape, kind, order)
    assert knead.deform(v, pull, out=out) is out
    assert bits(out) == bits(expected.astype(kind))


def test_out_that_overlaps(sphere, pull, expected):
    v = np.vstack([sphere.vertices, sphere.vertices])
    n = len(sphere.vertices)
    knead.deform(v[:n], pull, out=v[5 : n + 5])
    assert bits(v[5 : n + 5]) == bits(expected)


def test_in_place_with_faces(sphere, session):
    v = sphere.vertices.copy()
    assert knead.deform(v, session, sphere.faces, out=v) is v
    assert bits(v) == bits(knead.deform(sphere.vertices, session))


@pytest.mark.parametrize("out", [np.zeros((3, 3)), np.zeros(12), np.zeros((4, 3), int), [[0, 0, 0]] * 4, 5])
def test_wrong_out(out, pull):
    with pytest.raises((TypeError, knead.InvalidInput), match="out"):
        knead.deform(np.ones((4, 3)), pull, out=out)


def test_faces_of_all_kinds(sphere):
    v, f = sphere.vertices, sphere.faces
    expected = knead.check(v, f)
    for faces in (f.astype(np.int64), f.astype(np.int16 if len(v) < 32768 else np.int32), f.tolist(),
                  np.asfortranarray(f), [np.asarray(face) for face in f], tuple(map(tuple, f)), f[::-1]):
        assert knead.check(v, faces)["volume"] == pytest.approx(expected["volume"], rel=1e-12)
    quads = knead.check([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], np.array([[0, 1, 2, 3]]))
    assert quads["area"] == 1 and quads["triangles"] == 2
    mixed = knead.check([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]], [[0, 1, 2, 3], [1, 4, 2]])
    assert mixed["faces"] == 2
    for dtype in (np.int32, np.float64):
        arrays = [np.array([0, 1, 2, 3], dtype), np.array([1, 4, 2], dtype)]
        assert knead.check([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]], arrays)["faces"] == 2
    assert knead.check(v, None)["faces"] == 0 and knead.check(v, [])["faces"] == 0


@pytest.mark.parametrize(
    "faces",
    [[[0, 1, 99]], [[0, 1, -1]], np.array([[0, 1, 2**40]]), np.array([[0, 1, 2**64 - 1]], np.uint64), [0, 1, 2],
     [[0.5, 1, 2]], "abc", 7, [["a", "b", "c"]], np.array([0, 1, 2]), [[[0, 1, 2]]], [None]],
)
def test_wrong_faces(faces):
    with pytest.raises((TypeError, knead.InvalidInput), match="faces"):
        knead.check([[0, 0, 0], [1, 0, 0], [0, 1, 0]], faces)


def test_results_own_their_memory(sphere, pull):
    bench = knead.Workbench(sphere.vertices, sphere.faces)
    view = bench.vertices
    flow = knead.Flow(pull)
    moved = flow(sphere.vertices)
    del bench, flow
    gc.collect()
    assert bits(view) == bits(sphere.vertices) and bits(moved) == bits(knead.deform(sphere.vertices, pull))


@pytest.mark.parametrize("keyword", ["relative_tolerance", "diagonal", "until"])
def test_whole_numbers_too_large_for_a_float(sphere, pull, keyword):
    with pytest.raises((TypeError, knead.InvalidInput)):
        knead.deform(sphere.vertices, pull, **{keyword: 10**400})
    with pytest.raises((TypeError, knead.InvalidInput)):
        sphere.vertices = [[10**400, 0, 0]]


def test_vertices_of_a_shape_are_real_numbers(files):
    shape = knead.read(files / "sphere.ply")
    for wrong in (shape.vertices * 1j, shape.vertices.astype(str), [[10**400, 0, 0]] * len(shape.vertices)):
        with pytest.raises(TypeError, match="real numbers"):
            shape.vertices = wrong
    shape.vertices = shape.vertices.tolist()
    assert bits(shape.vertices) == bits(knead.read(files / "sphere.ply").vertices)


def test_a_name_that_is_no_utf8_can_be_read_in_the_message():
    with pytest.raises(knead.InvalidInput, match=r"^\\x80: its name has no extension"):
        knead.read(b"\x80")


def test_one_session_moves_several_shapes():
    body = np.random.default_rng(5).normal(size=(300, 3))
    body /= np.linalg.norm(body, axis=1)[:, None]
    shirt = 1.1 * body
    pull = knead.Implicit(path=[[0, 0.9, 0], [0, 1.3, 0]], inner=0.2, outer=0.8)
    both = knead.deform(body, pull, also=[shirt])
    size = float(np.linalg.norm(np.ptp(body, axis=0)))
    assert np.array_equal(both[0], knead.deform(body, pull))
    assert np.array_equal(both[1], knead.deform(shirt, pull, diagonal=size))
    with pytest.raises(TypeError, match="sequence of shapes"):
        knead.deform(body, pull, also=shirt)


def test_chunks_have_the_bits_of_the_whole(sphere, pull):
    size = float(np.linalg.norm(np.ptp(sphere.vertices, axis=0)))
    whole = knead.deform(sphere.vertices, pull)
    for count in (3, 7):
        parts = [knead.deform(part, pull, diagonal=size) for part in np.array_split(sphere.vertices, count)]
        assert bits(np.concatenate(parts)) == bits(whole)


def test_paths_are_no_shapes_and_no_sessions(sphere, pull, tmp_path):
    with pytest.raises(TypeError, match="read it by knead.read"):
        knead.deform("file.stl", pull)
    with pytest.raises(TypeError, match="knead.Session.read"):
        knead.deform(sphere.vertices, tmp_path / "s.knead")
    with pytest.raises(TypeError, match="knead.Session.read"):
        knead.Session("s.knead")
    with pytest.raises(TypeError, match=r"got Flow; a Flow moves points by flow\(points\)"):
        knead.deform(sphere.vertices, knead.Flow(pull))


def test_scenes_and_images(sphere, pull):
    scene = type("Scene", (), {"geometry": {}})()
    for take in (knead.deform, knead.deform_mesh):
        with pytest.raises(TypeError, match="several meshes"):
            take(scene, pull)

    class Grid:
        def __init__(self, points):
            self.points = points

        def copy(self):
            return Grid(self.points.copy())

    class Image:
        points = property(lambda self: sphere.vertices)

        def cast_to_structured_grid(self):
            return Grid(sphere.vertices.copy())

    moved = knead.deform_mesh(Image(), pull)
    assert isinstance(moved, Grid) and bits(moved.points) == bits(knead.deform(sphere.vertices, pull))
