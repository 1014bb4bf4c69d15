"""The quality of the cells of volume meshes."""

import knead
import numpy as np
import pytest

CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)


def grid(n):
    """A unit cube of n^3 hexahedra."""
    axis = np.linspace(-0.5, 0.5, n + 1)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
    number = np.arange((n + 1) ** 3).reshape((n + 1,) * 3)
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    cells = np.stack([number[i : n + i, j : n + j, k : n + k].ravel() for i, j, k in corners], 1)
    return points, cells


def tetrahedra(cells):
    """Six for each hexahedron, about its diagonal."""
    ways = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]
    return np.concatenate([cells[:, way] for way in ways])


def turned(points, degrees):
    turn = knead.Rotate(center=[0, 0, 0], axis=[0, 0, 1], angle_deg=degrees, inner=0.12, outer=0.42)
    return knead.deform(points, turn)


def test_a_cube_in_every_kind_of_cell():
    quality = knead.check_cells(CUBE, np.arange(8)[None])
    assert quality["volume"] == [1] and quality["scaled_jacobian"] == [1] and not quality["inverted"].any()
    for cells in (tetrahedra(np.arange(8)[None]), [[0, 3, 1, 4, 7, 5], [1, 3, 2, 5, 7, 6]]):
        quality = knead.check_cells(CUBE, np.array(cells))
        assert quality["volume"].sum() == pytest.approx(1)
        assert not quality["inverted"].any() and (quality["scaled_jacobian"] > 0).all()
    pyramids = np.array([[0, 3, 2, 1, 6], [0, 1, 5, 4, 6], [0, 4, 7, 3, 6]])
    assert np.abs(knead.check_cells(CUBE, pyramids)["volume"]).sum() == pytest.approx(1)


def test_a_mirror_turns_cells_inside_out():
    points, cells = grid(3)
    for block in (cells, tetrahedra(cells)):
        quality = knead.check_cells(points * [1, 1, -1], block)
        assert quality["inverted"].all() and quality["volume"].sum() == pytest.approx(-1)
        assert not knead.check_cells(points * [1, 1, -1], block, before=points * [1, 1, -1])["inverted"].any()
        assert knead.check_cells(points * [1, 1, -1], block, before=points)["inverted"].all()


def test_a_flow_keeps_the_volume_of_cells():
    points, cells = grid(24)
    for block in (cells, tetrahedra(cells)):
        quality = knead.check_cells(turned(points, 60), block, before=points)
        assert not quality["inverted"].any() and quality["scaled_jacobian"].min() > 0
        assert np.abs(quality["volume_ratio"] - 1).mean() < 0.03
        assert quality["volume"].sum() == pytest.approx(1)
    strong = knead.check_cells(turned(points, 150), cells, before=points)
    assert strong["inverted"].sum() > 0
    assert (strong["scaled_jacobian"][strong["inverted"]] < 0.5).all()


def test_gmsh_orders_wedges_the_other_way():
    wedge = np.array([[0, 1, 3, 4, 5, 7]])
    assert knead.check_cells(CUBE, wedge)["inverted"].all()
    quality = knead.check_cells(CUBE * 2, wedge, before=CUBE)
    assert not quality["inverted"].any() and (quality["scaled_jacobian"] > 0).all()
    assert quality["volume_ratio"] == pytest.approx(8)


def test_cells_that_were_flat_before_are_not_counted():
    flat = CUBE[[0, 1, 2, 2, 4, 5, 6, 6]]
    cell = np.arange(8)[None]
    assert knead.check_cells(flat, cell)["inverted"].all()
    assert not knead.check_cells(2 * flat, cell, before=flat)["inverted"].any()


def test_cells_of_meshio():
    meshio = pytest.importorskip("meshio")
    points, cells = grid(6)
    blocks = [("triangle", [[0, 1, 2]]), ("hexahedron", cells[:100]), ("tetra", tetrahedra(cells[100:]))]
    mesh = meshio.Mesh(points, blocks)
    after = knead.deform_mesh(mesh, knead.Implicit(path=[[0, 0, 0], [0.1, 0, 0]], inner=0.1, outer=0.45))
    quality = knead.check_cells(after.points, after.cells, before=mesh.points)
    assert len(quality["volume"]) == 100 + 6 * (len(cells) - 100)
    assert quality["volume"].sum() == pytest.approx(1, abs=1e-3)  # where both kinds meet, their faces differ
    assert not quality["inverted"].any()
    assert len(knead.check_cells(points, meshio.Mesh(points, blocks[:1]).cells)["volume"]) == 0


def test_what_is_no_cell():
    with pytest.raises(knead.InvalidInput, match="cell 0 has the corner 9, but there are 8 points"):
        knead.check_cells(CUBE, np.array([[0, 1, 2, 9]]))
    with pytest.raises(knead.InvalidInput, match="shape"):
        knead.check_cells(CUBE, np.array([[0, 1, 2]]))
    with pytest.raises(TypeError, match="whole numbers"):
        knead.check_cells(CUBE, CUBE[:1, [0, 1, 2, 0]])
    assert len(knead.check_cells(CUBE, np.empty((0, 4), int))["volume"]) == 0
