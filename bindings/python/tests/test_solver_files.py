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
