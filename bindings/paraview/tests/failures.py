"""What the filter refuses, and what it says then."""

import re

import numpy as np

from support import *  # noqa: F403
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkFileOutputWindow, vtkIdList, vtkOutputWindow, vtkPoints
from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader, vtkXMLUnstructuredGridWriter

log = path_of(f"messages_{RANKS}")
window = vtkFileOutputWindow()
window.SetFileName(log)
window.FlushOn()
vtkOutputWindow.SetInstance(window)
seen = 0
CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)


def messages():
    """What was said since the last call."""
    global seen
    try:
        with open(log) as file:
            text = file.read()
    except FileNotFoundError:
        return ""
    new, seen = text[seen:], len(text)
    return new


def refusal(source, session, **properties):
    messages()
    result = deformed(source, session, **properties)
    require(sum(data.GetNumberOfPoints() for data in leaves(result)) == 0, f"{session}: there is a result")
    return messages()


def test_inversion():
    source = opened("box.vtu")
    said = refusal(source, "invert")
    require("knead.deform_mesh" in said, "it does not say what repairs cells")
    found = re.search(r"(\d+) cells are inverted, the first is cell (\d+).*up to Until = ([0-9.e-]*[0-9])", said)
    require(found, f"does not name the cell and the part: {said}")
    until = float(found[3])
    require(0 < until < 1, f"Until = {until}")
    safe = leaves(deformed(source, "invert", Until=until))[0]
    require(safe.GetNumberOfPoints() > 0, "what it proposes is refused")
    require(array_of(safe.GetCellData(), "KneadScaledJacobian").min() > 0, "what it proposes inverts a cell")
    require("inverted" in refusal(source, "invert", Until=until + 2 / 1024), "it could have gone farther")
    advice = re.search(r'line 2: an "outer" of ([0-9.]+) fits', said)
    require(advice and 0.499 <= float(advice[1]) < 0.5, f"no distance from the centre to the faces: {said}")

    said = refusal(source, "back", Until=1.9)
    at_once = re.search(r"up to Until = ([0-9.e-]*[0-9])", said)
    require(at_once and float(at_once[1]) < until + 1 / 1024, f"does not see that it inverts at once: {said}")

    messages()
    all_of_it = leaves(deformed(source, "invert", FailOnInversion=0))[0]
    count = int(array_of(all_of_it.GetFieldData(), "KneadInvertedCells")[0])
    require(count == int(found[1]) and f"{count} cells are inverted" in messages(), "no warning, or another count")
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(path_of("box.vtu"))
    reader.Update()
    whole = reader.GetOutput()
    corners = np.array([[whole.GetCell(i).GetPointId(k) for k in range(4)] for i in range(whole.GetNumberOfCells())])
    moved = knead.deform(points_of(whole), knead.Session.read(session_file("invert")), diagonal=diagonal_of(source),
                         precision="float64")
    inverted = knead.check_cells(moved, corners, before=points_of(whole))["inverted"]
    require(inverted.sum() == count, f"{count} cells, but the library counts {inverted.sum()}")
    if RANKS == 1:
        require(np.flatnonzero(inverted)[0] == int(found[2]), "another cell is the first")
        require((array_of(all_of_it.GetCellData(), "KneadScaledJacobian")[inverted] < 0).all(), "inverted, but not below 0")


def test_thin_cells_of_floats():
    """A warning where float coordinates hardly resolve an edge, and none with doubles."""
    for thickness, kind, expected in [(1e-4, np.float32, True), (1e-4, np.float64, False), (0.1, np.float32, False)]:
        corners = CUBE * [1, 1, thickness] + [0, 0, 1]
        grid = vtkUnstructuredGrid()
        points = vtkPoints()
        points.SetData(numpy_to_vtk(corners.astype(kind), deep=1))
        grid.SetPoints(points)
        ids = vtkIdList()
        for k in range(8):
            ids.InsertNextId(k)
        grid.InsertNextCell(12, ids)
        writer = vtkXMLUnstructuredGridWriter()
        writer.SetFileName(path_of("thin.vtu"))
        writer.SetInputData(grid)
        writer.Write()
        source = simple.OpenDataFile(path_of("thin.vtu"))  # one cell: other ranks have none
        messages()
        deformed(source, "move")
        require(("64-bit Floats" in messages()) == expected, f"{thickness} {kind}: the warning")


def test_surface():
    said = refusal(opened("box.vtu"), "surface")
    file = session_file("surface")
    command = f"knead resolve SHAPE {file} -o {path_of('surface.resolved.knead')}"
    require(f"{file}:2: " in said and command in said, said)


def test_bad_properties():
    source = opened("box.vtu")
    require("SessionFile is empty" in refusal_of(source, SessionFile=""), "an empty name")
    require("cannot be opened" in refusal(source, "missing") or "missing" in refusal(source, "missing"), "no such file")
    require("VectorsToTransform" in refusal(source, "move", VectorsToTransform=["vorticity"]), "no such array")


def refusal_of(source, **properties):
    messages()
    result = simple.Knead(Input=source, **properties)
    result.UpdatePipeline()
    require(sum(data.GetNumberOfPoints() for data in leaves(result)) == 0, "there is a result")
    return messages()


run_tests(globals())
