"""Shapes, flows and surfaces are copied, pickled and made from arrays; meshes of other packages are taken everywhere."""

import copy
import multiprocessing
import pickle
import types

import numpy as np
import pytest

import knead

PULL = knead.Implicit(path=[[0, 0, 1], [0, 0, 1.4]], inner=0.2, outer=0.8)
POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
WAYS = [copy.copy, copy.deepcopy, lambda thing: pickle.loads(pickle.dumps(thing))]


@pytest.mark.parametrize("way", WAYS)
def test_copies_of_a_shape_share_nothing(way):
    shape = knead.Shape(POINTS, FACES)
    again = way(shape)
    assert (again.vertices == POINTS).all() and (again.faces == FACES).all() and again.format == shape.format
    again.vertices[:] = 7
    assert (shape.vertices == POINTS).all()


def test_a_copy_has_the_moved_vertices_and_the_rest_of_the_file(tmp_path):
    (tmp_path / "a.obj").write_text("# a note\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    shape = knead.read(tmp_path / "a.obj")
    shape.vertices[2, 1] = 2
    for way in WAYS:
        way(shape).write(tmp_path / "b.obj")
        assert (tmp_path / "b.obj").read_text() == "# a note\nv 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n"


@pytest.mark.parametrize("way", WAYS)
def test_copies_of_a_flow_move_points_to_the_same_bits(way):
    twist = knead.Flow(knead.Twist(center=[0, 0, 0], axis=[0, 0, 1], rate_deg=30, inner=-1, outer=1))
    for flow in (knead.Flow(PULL), knead.Flow(PULL).inverse(), knead.Flow(PULL).part(0, 0.5), knead.Flow(PULL) + twist):
        again = way(flow)
        assert again == flow
        assert (again(POINTS) == flow(POINTS)).all()


@pytest.mark.parametrize("way", WAYS)
def test_copies_of_a_surface_move_alone(way):
    surface = knead.Surface(POINTS, FACES)
    again = way(surface)
    again.move(POINTS * 2)
    assert surface.hit([0.2, 0.2, -1], [0, 0, 1])[0] == pytest.approx([0.2, 0.2, 0])
    assert again.hit([0.1, 3, 0.1], [0, -1, 0])[0][1] == pytest.approx(1.8)


@pytest.mark.parametrize("make", [lambda: knead.Workbench(POINTS, FACES), lambda: knead.PaintDrag(outer=1, depth=0.1)])
def test_what_cannot_be_sent_says_what_to_send(make):
    for way in WAYS:
        with pytest.raises(TypeError, match="send its"):
            way(make())


def test_arrays_are_written(tmp_path):
    knead.write(tmp_path / "a.obj", POINTS, FACES)
    shape = knead.read(tmp_path / "a.obj")
    assert (shape.vertices == POINTS).all() and (shape.faces == FACES).all()
    knead.write(tmp_path / "b.xyz", POINTS)
    assert (knead.read(tmp_path / "b.xyz").vertices == POINTS).all()


def test_meshes_are_taken_by_all_functions():
    flat = np.hstack([[3, *face] for face in FACES])
    for mesh in (
        types.SimpleNamespace(vertices=POINTS, faces=FACES),  # as trimesh
        types.SimpleNamespace(points=POINTS, faces=flat),  # as pyvista
        types.SimpleNamespace(points=POINTS, cells=[types.SimpleNamespace(type="triangle", data=FACES)]),  # as meshio
        knead.Shape(POINTS, FACES),
    ):
        assert knead.check(mesh)["volume"] == pytest.approx(1 / 6)
        assert len(knead.crossings(mesh)) == 0
        assert knead.Surface(mesh).hit([0.2, 0.2, -1], [0, 0, 1]) is not None
        assert len(knead.remesh(mesh, max_edge=0.5).vertices) > 4
        assert len(knead.Shape(mesh).faces) == 4
        assert (knead.Workbench(mesh).faces == FACES).all()


def test_faces_may_be_reals_that_are_whole_numbers():
    for faces in (FACES.astype(float), FACES.astype(float).tolist(), [tuple(map(float, face)) for face in FACES]):
        assert knead.check(POINTS, faces)["volume"] == pytest.approx(1 / 6)
    with pytest.raises(TypeError, match="faces"):
        knead.check(POINTS, FACES + 0.5)


def test_masked_values_are_refused():
    masked = np.ma.masked_array(POINTS, mask=POINTS == 1)
    with pytest.raises(knead.InvalidInput, match="masked"):
        knead.deform(masked, PULL)
    assert (knead.deform(np.ma.masked_array(POINTS), PULL) == knead.deform(POINTS, PULL)).all()


def test_cells_are_computed_in_double_by_default():
    points = np.vstack([POINTS, [[0.3, 0.3, 1 / 3]]])
    cells = [types.SimpleNamespace(type="tetra", data=np.array([[0, 1, 2, 4]]))]
    exact = knead.deform(points, PULL, precision="float64")
    assert (knead.deform_cells(points, cells, PULL)[0] == exact).all()
    assert (knead.deform_mesh(types.SimpleNamespace(points=points, cells=cells), PULL).points == exact).all()


def _render_in_child(_):
    try:
        knead.render(POINTS, FACES, size=(16, 16))
    except knead.Unavailable as error:
        return str(error)
    return ""


def test_a_forked_process_says_that_it_cannot_render():
    try:
        knead.render(POINTS, FACES, size=(16, 16))
    except knead.Unavailable:
        pytest.skip("there is no renderer here")
    with multiprocessing.get_context("fork").Pool(1) as pool:
        assert "spawn" in pool.map_async(_render_in_child, [0]).get(timeout=60)[0]
