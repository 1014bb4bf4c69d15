"""Meshes that meshio writes for solvers: knead deform moves their points, and meshio reads the same cells back."""

import subprocess

import numpy as np
import pytest
from conftest import COMMAND, run

import knead

meshio = pytest.importorskip("meshio")

POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 0.7], [1, 1, 1 / 3]])
CELLS = [("tetra", np.array([[0, 1, 2, 3], [1, 2, 3, 4]]))]
SESSION = '{"knead": 1}\n{"tool": "implicit", "path": [[0, 0, 0.7], [0, 0.11, 1]], "inner": 0.1, "outer": 1.4}\n'
# What meshio calls the format, its keywords, the extension, and the accuracy of the numbers that the file can hold.
KINDS = [
    ("gmsh22", {"binary": False}, "msh", 1e-15), ("gmsh22", {"binary": True}, "msh", 0),
    ("gmsh", {"binary": False}, "msh", 1e-15), ("gmsh", {"binary": True}, "msh", 0),
    ("nastran", {"point_format": "fixed-large"}, "bdf", 1e-10), ("nastran", {"point_format": "fixed-small"}, "nas", 1e-4),
    ("nastran", {"point_format": "free"}, "bdf", 1e-10), ("abaqus", {}, "inp", 1e-13), ("su2", {}, "su2", 1e-15),
]


@pytest.mark.parametrize("kind, keywords, extension, accuracy", KINDS)
def test_meshio_reads_back_what_knead_moved(kind, keywords, extension, accuracy, tmp_path):
    before, after, session = tmp_path / f"a.{extension}", tmp_path / f"b.{extension}", tmp_path / "pull.knead"
    session.write_text(SESSION)
    meshio.Mesh(POINTS, CELLS).write(before, file_format=kind, **keywords)
    run("deform", before, session, "-q", "--precision", "double", "--digits", "shortest", "-o", after)
    moved = meshio.read(after, file_format="gmsh" if extension == "msh" else kind)
    expected = knead.deform(knead.read(before).vertices, knead.Session.read(session), precision="float64")
    assert np.abs(expected - POINTS).max() > 0.1
    assert np.abs(moved.points - expected).max() <= 2 * accuracy
    assert np.array_equal(moved.cells[0].data, CELLS[0][1])
    shape = knead.read(before)
    shape.vertices = expected
    shape.write(tmp_path / f"c.{extension}")
    assert (tmp_path / f"c.{extension}").read_bytes() == after.read_bytes()


@pytest.fixture(scope="module", params=[(shape, order) for shape in ("tetrahedra", "prisms", "hexahedra", "plane") for order in (1, 2)],
                ids=lambda p: f"{p[0]}-{p[1]}")
def files_of_gmsh(request, tmp_path_factory):
    """A unit cube or square with physical groups, in every format and version that gmsh writes."""
    gmsh = pytest.importorskip("gmsh")
    shape, order = request.param
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.model.add("m")
    geo = gmsh.model.geo
    corners = [geo.addPoint(x, y, 0, 0.3) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))]
    lines = [geo.addLine(corners[k], corners[(k + 1) % 4]) for k in range(4)]
    plane = geo.addPlaneSurface([geo.addCurveLoop(lines)])
    if shape == "hexahedra":
        geo.mesh.setTransfiniteSurface(plane)
        geo.mesh.setRecombine(2, plane)
    if shape != "plane":
        geo.extrude([(2, plane)], 0, 0, 1, [] if shape == "tetrahedra" else [3], recombine=shape != "tetrahedra")
    geo.synchronize()
    dimension = 2 if shape == "plane" else 3
    for d in range(dimension + 1):
        tags = [tag for _, tag in gmsh.model.getEntities(d)]
        gmsh.model.setPhysicalName(d, gmsh.model.addPhysicalGroup(d, tags), f"group {d}")
    gmsh.model.mesh.generate(dimension)
    gmsh.model.mesh.setOrder(order)
    folder = tmp_path_factory.mktemp("gmsh")
    files = []
    for name, options in (("22.msh", {"MshFileVersion": 2.2}), ("22b.msh", {"MshFileVersion": 2.2, "Binary": 1}),
                          ("22p.msh", {"MshFileVersion": 2.2, "SaveParametric": 1}), ("41.msh", {"MshFileVersion": 4.1}),
                          ("41b.msh", {"MshFileVersion": 4.1, "Binary": 1, "SaveParametric": 1}), ("a.su2", {}), ("a.unv", {}),
                          ("a.inp", {}), ("free.bdf", {"BdfFieldFormat": 0}), ("small.bdf", {"BdfFieldFormat": 1}),
                          ("large.bdf", {"BdfFieldFormat": 2})):
        for key, value in {"Binary": 0, "SaveParametric": 0, **options}.items():
            gmsh.option.setNumber(f"Mesh.{key}", value)
        gmsh.write(str(folder / name))
        files.append(folder / name)
    gmsh.finalize()
    return files, order


def test_files_of_gmsh_keep_all_but_their_points(files_of_gmsh, tmp_path):
    files, order = files_of_gmsh
    (tmp_path / "none.knead").write_text('{"knead": 1}\n')
    (tmp_path / "pull.knead").write_text('{"knead": 1}\n{"tool": "implicit", "path": [[0.5, 0.5, 0], [0.55, 0.52, 0]], "inner": 0.1, "outer": 0.6}\n')
    for file in files:
        before, after = file.read_bytes(), tmp_path / file.name
        run("deform", file, tmp_path / "none.knead", "-q", "-o", after)
        assert after.read_bytes() == before, file.name
        run("deform", file, tmp_path / "pull.knead", "-q", "-o", after)
        moved = (knead.read(after).vertices != knead.read(file).vertices).any(axis=1).sum()
        assert moved > 10, file.name
        if file.name.endswith("b.msh"):
            assert len(after.read_bytes()) == len(before)
        elif file.suffix != ".bdf":  # whose fields may touch each other
            words = list(zip(before.split(), after.read_bytes().split(), strict=True))
            assert sum(a != b for a, b in words) <= 3 * moved, file.name
        if file.suffix == ".msh" or (file.suffix == ".su2" and order == 1):
            run("check", file, "-q", "--require", "no-inverted-cells")


def test_other_formats_go_through_meshio(tmp_path):
    """The recipe of docs/engineers.md, for CGNS."""
    pytest.importorskip("h5py")
    meshio.Mesh(POINTS, CELLS).write(tmp_path / "a.cgns")
    mesh = meshio.read(tmp_path / "a.cgns")
    mesh.points, report = knead.deform_cells(mesh.points, mesh.cells, knead.Session.parse(SESSION))
    assert report["result"]["inverted"] == 0
    mesh.write(tmp_path / "b.cgns")
    again = meshio.read(tmp_path / "b.cgns")
    assert np.abs(again.points - mesh.points).max() < 1e-12 and np.abs(mesh.points - POINTS).max() > 0.1
    assert np.array_equal(again.cells[0].data, CELLS[0][1])


def test_a_broken_file_gives_one_line(tmp_path):
    (tmp_path / "a.msh").write_text("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 9 1 9\n0 1 0 9\n1\n")
    (tmp_path / "pull.knead").write_text(SESSION)
    done = subprocess.run([COMMAND, "deform", "a.msh", "pull.knead", "-o", "b.msh"], cwd=tmp_path, capture_output=True,
                          text=True)
    assert done.returncode == 3 and not (tmp_path / "b.msh").exists()
    assert done.stderr.splitlines()[-1] == (
        "knead: a.msh:6: 9 points are declared, but only 3 bytes follow; the file is cut short or damaged")
