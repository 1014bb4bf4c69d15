"""The quality of the cells of volume meshes."""

from types import SimpleNamespace

import knead
import numpy as np
import pytest
from conftest import run

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


def test_cells_between_which_faces_are_slanted():
    """By the definitions of OpenFOAM's checkMesh; src/cells/cell_faces_test.cpp has more."""
    points, cells = grid(3)
    straight = knead.check_cells(points, cells)
    assert straight["non_orthogonality_deg"].max() < 1e-6 and straight["skewness"].max() < 1e-9
    assert straight["aspect_ratio"] == pytest.approx(np.ones(27))
    long = knead.check_cells(points * [4, 1, 1], cells)["aspect_ratio"]
    assert long == pytest.approx(np.full(27, 4.0))  # the areas along x are a quarter of the others
    sheared = points + points[:, 2:] * [1, 0, 0]
    quality = knead.check_cells(sheared, cells, before=points)
    assert quality["non_orthogonality_deg"] == pytest.approx(np.full(27, 45.0))
    mirrored = knead.check_cells(sheared * [1, 1, -1], cells)
    assert mirrored["non_orthogonality_deg"] == pytest.approx(np.full(27, 45.0))
    meshio = pytest.importorskip("meshio")
    # In two blocks they are still neighbours.
    blocks = [meshio.CellBlock("hexahedron", cells[:10]), meshio.CellBlock("hexahedron", cells[10:])]
    assert np.array_equal(knead.check_cells(sheared, blocks)["skewness"], quality["skewness"])
    assert len(knead.check_cells(points, [])["skewness"]) == 0


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
    as_vtk = wedge[:, [0, 2, 1, 3, 5, 4]]
    with pytest.warns(UserWarning, match="look inward, as Gmsh numbers them"):
        quality = knead.check_cells(CUBE, wedge)
    for key, values in knead.check_cells(CUBE, as_vtk).items():
        assert (quality[key] == values).all(), key
    assert not quality["inverted"].any()
    with pytest.warns(UserWarning, match="Gmsh"):
        quality = knead.check_cells(CUBE * 2, wedge, before=CUBE)
    assert not quality["inverted"].any() and (quality["scaled_jacobian"] > 0).all()
    assert quality["volume_ratio"] == pytest.approx(8)


def test_gmsh_wedges_beside_hexahedra():
    """A hexahedron, and a wedge on its side x = 1 in Gmsh's order."""
    points = np.vstack([CUBE, [[2, 0, 0], [2, 0, 1]]])
    blocks = [type("Block", (), {"type": kind, "data": np.array([corners])})() for kind, corners in
              (("hexahedron", range(8)), ("wedge", (1, 8, 2, 5, 9, 6)))]
    with pytest.warns(UserWarning, match="Gmsh"):
        quality = knead.check_cells(points, blocks)
    assert not quality["inverted"].any() and quality["non_orthogonality_deg"].max() < 40
    with pytest.warns(UserWarning, match="Gmsh"):
        moved, report = knead.deform_cells(points, blocks, knead.Implicit(path=[[0, 0, 0], [0.1, 0, 0]], inner=0.1, outer=0.5))
    assert report["result"]["inverted"] == 0 and report["result"]["least_scaled_jacobian"] > 0.3


def test_cells_that_were_flat_before_are_not_counted():
    flat = CUBE * [1, 1, 0]
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


STRONG = knead.Rotate(center=[0, 0, 0], axis=[0, 0, 1], angle_deg=110, inner=0.12, outer=0.42)


@pytest.mark.parametrize("split", [tetrahedra, lambda cells: cells])
def test_interior_points_are_free(split):
    points, cells = grid(16)
    cells = split(cells)
    whole = knead.deform(points, STRONG)
    moved, report = knead.deform_cells(points, cells, STRONG)
    quality = knead.check_cells(moved, cells, before=points)
    assert report["flow"]["inverted"] == knead.check_cells(whole, cells, before=points)["inverted"].sum() > 0
    assert report["result"]["inverted"] == quality["inverted"].sum() == 0
    assert report["result"]["least_scaled_jacobian"] == quality["scaled_jacobian"].min() >= 0.05
    assert report["result"]["mean_volume_change"] == pytest.approx(np.abs(quality["volume_ratio"] - 1).mean())
    outside = (np.abs(points) == 0.5).any(1) | (np.linalg.norm(points, axis=1) > 0.42)
    assert (moved[outside] == whole[outside]).all()
    assert 0 < (moved != whole).any(1).sum() <= report["freed"]
    assert (knead.deform_cells(points, cells, STRONG, threads=1)[0] == moved).all()

    fixed = np.ones(len(points), bool)
    same, report = knead.deform_cells(points, cells, STRONG, fixed=fixed)
    assert (same == whole).all() and report["freed"] == 0 and report["result"] == report["flow"]


def test_deform_mesh_keeps_cells_good():
    meshio = pytest.importorskip("meshio")
    points, cells = grid(16)
    marked = cells[(np.abs(points[cells].mean(1)) < 0.1).all(1)][:, :4]
    mesh = meshio.Mesh(points, [("tetra", tetrahedra(cells)), ("quad", marked)])
    report = {}
    after = knead.deform_mesh(mesh, STRONG, least_scaled_jacobian=0.05, report=report)
    assert (mesh.points == points).all()
    quality = knead.check_cells(after.points, after.cells, before=points)
    assert report["flow"]["inverted"] > 0 == report["result"]["inverted"] == quality["inverted"].sum()
    assert (after.points[marked] == knead.deform(points, STRONG)[marked]).all()
    with pytest.raises(knead.InvalidInput, match="needs a mesh with volume cells"):
        knead.deform_mesh(meshio.Mesh(points, [("quad", marked)]), STRONG, least_scaled_jacobian=0.05)


def test_what_deform_cells_refuses():
    points, cells = grid(4)
    for least in (0, 0.6, float("nan")):
        with pytest.raises(knead.InvalidInput, match="least scaled Jacobian"):
            knead.deform_cells(points, cells, STRONG, least_scaled_jacobian=least)
    with pytest.raises(knead.InvalidInput, match="fixed must have shape"):
        knead.deform_cells(points, cells, STRONG, fixed=[True])
    with pytest.raises(knead.InvalidInput, match="cell 0 has the corner 93, but there are 5 points"):
        knead.deform_cells(points[:5], cells[-1:], STRONG)
    assert knead.deform_cells(points, cells, STRONG, progress=lambda _: False) == (None, None)


@pytest.mark.parametrize("bound", [0, 0.1])
def test_how_far_is_safe(bound):
    points, cells = grid(16)
    cells = tetrahedra(cells)
    strong = knead.Rotate(center=[0, 0, 0], axis=[0, 0, 1], angle_deg=150, inner=0.12, outer=0.3)
    found = knead.safe_until(points, cells, strong, least_scaled_jacobian=bound)
    assert 0 < found["until"] < found["beyond"] < 1
    good = knead.check_cells(knead.deform(points, strong, until=found["until"]), cells, before=points)
    bad = knead.check_cells(knead.deform(points, strong, until=found["beyond"]), cells, before=points)
    assert not good["inverted"].any() and good["scaled_jacobian"].min() >= bound
    assert bad["scaled_jacobian"].argmin() == found["cell"]
    assert bad["scaled_jacobian"].min() == found["scaled_jacobian"] < max(bound, 1e-12)
    assert found["outer"] == knead.widest_outer(points, cells, strong) == pytest.approx(0.5, abs=2e-3)
    wide = strong.replace(outer=found["outer"])
    rests = (knead.deform(points, wide) == points).all(1)
    assert rests[(np.abs(points) == 0.5).any(1)].all()
    assert knead.safe_until(points, cells, wide, least_scaled_jacobian=bound)["until"] > found["until"]

    slight = strong.replace(angle_deg=3)
    safe = knead.safe_until(points, cells, slight, least_scaled_jacobian=bound)
    assert safe == {"until": 1, "beyond": 1, "cell": None, "scaled_jacobian": None, "outer": None}
    assert knead.safe_until(points, cells, [slight, strong], until=1)["until"] == 1
    assert knead.safe_until(points, cells, strong, inverse=True)["until"] < 1


def test_what_safe_until_refuses():
    points, cells = grid(4)
    for least in (-1, 1, float("nan")):
        with pytest.raises(knead.InvalidInput, match="least scaled Jacobian"):
            knead.safe_until(points, cells, STRONG, least_scaled_jacobian=least)
    with pytest.raises(knead.InvalidInput, match="until"):
        knead.safe_until(points, cells, STRONG, until=2)
    with pytest.raises(knead.InvalidInput, match="one stroke"):
        knead.widest_outer(points, cells, [STRONG, STRONG])
    assert knead.safe_until(points, cells, STRONG, progress=lambda _: False) is None
    assert knead.widest_outer(points, cells, knead.Bend(center=[0, 0, 0], axis=[1, 0, 0], normal=[0, 0, 1], width=0.2, angle_deg=5)) is None


def bricks(path):
    """A cube of 5 x 5 x 5 hexahedra, also as a file of gmsh."""
    points, cells = grid(5)
    rows = [f"{i} {' '.join(map(repr, map(float, p)))}" for i, p in enumerate(points, 1)]
    of_cells = [f"{i} 5 2 1 1 {' '.join(map(str, c + 1))}" for i, c in enumerate(cells, 1)]
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", "216", *rows, "$EndNodes", "$Elements", "125", *of_cells, "$EndElements"]
    path.write_text("\n".join(lines) + "\n")
    return points, cells


def test_deform_judges_the_cells_of_files_and_meshes(tmp_path):
    path = tmp_path / "bricks.msh"
    points, cells = bricks(path)
    shape = knead.read(path)
    mesh = SimpleNamespace(points=points, cells=[SimpleNamespace(type="hexahedron", data=cells)])

    def past_a_neighbour(z):
        return knead.Implicit(path=[[-0.1, -0.1, z], [0.15, 0, z]], inner=0.05, outer=0.3)

    gentle, inside, outside = knead.Rotate(center=[0, 0, 0], axis=[0, 0, 1], angle_deg=10, inner=0.1, outer=0.5), past_a_neighbour(-0.1), past_a_neighbour(-0.5)
    ways = [lambda s: knead.deform(shape, s), lambda s: knead.deform(points, s, cells=cells), lambda s: knead.deform(mesh, s),
            lambda s: knead.deform_mesh(shape, s).vertices, lambda s: knead.deform_mesh(mesh, s, precision="float32").points]
    assert knead.check_cells(knead.deform(points, inside), cells, points)["inverted"].any()  # nobody knows of the cells
    knead.Session(inside).write(tmp_path / "inside.knead")
    run("deform", path, tmp_path / "inside.knead", "-q", "--digits", "shortest", "-o", tmp_path / "moved.msh")
    for way in ways:
        assert (way(gentle) == knead.deform(points, gentle)).all()
        with pytest.warns(UserWarning, match="leave the flow so that no cell is inverted"):
            moved = way(inside)
        assert (moved == knead.read(tmp_path / "moved.msh").vertices).all()
        assert not knead.check_cells(moved, cells, points)["inverted"].any() and np.abs(moved - points).max() > 0.01
        with pytest.raises(knead.AccuracyError, match="would be inverted"):
            way(outside)


def test_cells_that_cannot_be_read_are_not_judged(tmp_path):
    path = tmp_path / "bricks.msh"
    bricks(path)
    path.write_text(path.read_text().replace("\n7 5 2 1 1", "\n7 99 2 1 1"))
    shape = knead.read(path)
    move = knead.Rotate(center=[0, 0, 0], axis=[0, 0, 1], angle_deg=10, inner=0.1, outer=0.5)
    with pytest.warns(UserWarning, match="the cells are not judged: "):
        moved = knead.deform(shape, move)
    assert (moved == knead.deform(shape.vertices, move)).all()
