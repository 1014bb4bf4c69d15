"""Makes the data sets and sessions of the tests in $KNEAD_SCRATCH; every point has its place in the array KneadTestStart.

Needs the vtkmodules that ParaView brings.
"""

import os
import subprocess

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkIdList, vtkPoints
from vtkmodules.vtkCommonDataModel import (
    vtkCellArray,
    vtkImageData,
    vtkMultiBlockDataSet,
    vtkPartitionedDataSetCollection,
    vtkPolyData,
    vtkRectilinearGrid,
    vtkStructuredGrid,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkFiltersCore import vtkExtractCells
from vtkmodules.vtkIOParallelXML import vtkXMLPartitionedDataSetCollectionWriter
from vtkmodules.vtkIOPLY import vtkPLYReader
from vtkmodules.vtkIOXML import (
    vtkXMLImageDataWriter,
    vtkXMLMultiBlockDataWriter,
    vtkXMLPolyDataWriter,
    vtkXMLRectilinearGridWriter,
    vtkXMLStructuredGridWriter,
    vtkXMLUnstructuredGridWriter,
)

scratch = os.environ["KNEAD_SCRATCH"]
random = np.random.default_rng(23)

CUBE = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
FACES = [[0, 3, 2, 1], [4, 5, 6, 7], [0, 1, 5, 4], [1, 2, 6, 5], [2, 3, 7, 6], [3, 0, 4, 7]]
EDGES = [[0, 1], [1, 2], [2, 3], [3, 0], [4, 5], [5, 6], [6, 7], [7, 4], [0, 4], [1, 5], [2, 6], [3, 7]]
TETRAHEDRON = CUBE[[0, 1, 3, 4]]


def middles(corners, edges):
    return np.array([(corners[a] + corners[b]) / 2 for a, b in edges])


# The number that VTK has for each type of cell, and its points in the unit cube.
CELLS = {
    1: CUBE[:1],  # vertex
    3: CUBE[:2],  # line
    5: CUBE[:3],  # triangle
    8: CUBE[[0, 1, 3, 2]],  # pixel
    9: CUBE[:4],  # quadrilateral
    10: TETRAHEDRON,
    11: CUBE[[0, 1, 3, 2, 4, 5, 7, 6]],  # voxel
    12: CUBE,  # hexahedron
    13: CUBE[[0, 3, 1, 4, 7, 5]],  # wedge
    14: np.vstack([CUBE[:4], [[0.5, 0.5, 1]]]),  # pyramid
    24: np.vstack([TETRAHEDRON, middles(TETRAHEDRON, [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]])]),
    25: np.vstack([CUBE, middles(CUBE, EDGES)]),
    42: CUBE,  # polyhedron
}


def with_arrays(data, points):
    start = numpy_to_vtk(np.ascontiguousarray(points, dtype=np.float64), deep=True)
    start.SetName("KneadTestStart")
    data.GetPointData().AddArray(start)
    velocity = numpy_to_vtk(random.normal(size=(len(points), 3)), deep=True)
    velocity.SetName("velocity")
    data.GetPointData().AddArray(velocity)
    return data


def unstructured(points, cells):
    """cells: (type, numbers of points)."""
    grid = vtkUnstructuredGrid()
    held = vtkPoints()
    held.SetData(numpy_to_vtk(np.ascontiguousarray(points, dtype=np.float64), deep=True))
    grid.SetPoints(held)
    for kind, numbers in cells:
        ids = vtkIdList()
        if kind == 42:
            ids.InsertNextId(len(FACES))
            for face in FACES:
                ids.InsertNextId(4)
                for corner in face:
                    ids.InsertNextId(int(numbers[corner]))
        else:
            for number in numbers:
                ids.InsertNextId(int(number))
        grid.InsertNextCell(kind, ids)
    return with_arrays(grid, points)


def zoo(n):
    """Cells of all types side by side in the unit box, each with points of its own."""
    points, cells, kinds = [], [], list(CELLS)
    for i in range(n**3):
        kind = kinds[i % len(kinds)]
        corner = np.array([i % n, i // n % n, i // n**2]) / n
        cells.append((kind, range(sum(map(len, points)), sum(map(len, points)) + len(CELLS[kind]))))
        points.append(corner + CELLS[kind] * (0.8 / n))
    return unstructured(np.vstack(points), cells)


def box_of_tetrahedra(n, shake):
    """A grid of n^3 cubes in the unit box, of six tetrahedra each; its inner points are shaken."""
    axis = np.linspace(0, 1, n + 1)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1)
    points[1:-1, 1:-1, 1:-1] += random.uniform(-shake / n, shake / n, points[1:-1, 1:-1, 1:-1].shape)
    number = np.arange((n + 1) ** 3).reshape(n + 1, n + 1, n + 1)
    cells = []
    for x, y, z in np.ndindex(n, n, n):
        cube = [number[x + dx, y + dy, z + dz] for dx, dy, dz in CUBE.astype(int)]
        for a, b in [(1, 2), (2, 3), (3, 7), (7, 4), (4, 5), (5, 1)]:
            cells.append((10, [cube[0], cube[a], cube[b], cube[6]]))
    return unstructured(points.reshape(-1, 3), cells)


def image(n):
    grid = vtkImageData()
    grid.SetDimensions(n, n, n)
    grid.SetSpacing(1 / (n - 1), 1 / (n - 1), 1 / (n - 1))
    return with_arrays(grid, points_of(grid))


def rectilinear(n):
    grid = vtkRectilinearGrid()
    grid.SetDimensions(n, n, n)
    axis = numpy_to_vtk(np.linspace(0, 1, n) ** 1.5, deep=True)
    grid.SetXCoordinates(axis)
    grid.SetYCoordinates(axis)
    grid.SetZCoordinates(axis)
    return with_arrays(grid, points_of(grid))


def curvilinear(n):
    axis = np.linspace(0, 1, n)
    z, y, x = np.meshgrid(axis, axis, axis, indexing="ij")
    points = np.stack([x + 0.05 * y * z, y + 0.05 * x * x, z], -1).reshape(-1, 3)
    grid = vtkStructuredGrid()
    grid.SetDimensions(n, n, n)
    held = vtkPoints()
    held.SetData(numpy_to_vtk(points, deep=True))
    grid.SetPoints(held)
    return with_arrays(grid, points)


def points_of(grid):
    return np.array([grid.GetPoint(i) for i in range(grid.GetNumberOfPoints())])


def write(writer, data, name):
    writer.SetFileName(os.path.join(scratch, name))
    writer.SetInputData(data)
    writer.SetDataModeToBinary()
    if not writer.Write():
        raise SystemExit(f"could not write {name}")


def write_in_pieces(source, name):
    """A surface as two pieces that share the points along their border, for two ranks."""
    reader = vtkPLYReader()
    reader.SetFileName(os.path.join(scratch, source))
    reader.Update()
    whole = reader.GetOutput()
    points = vtk_to_numpy(whole.GetPoints().GetData())
    faces = vtk_to_numpy(whole.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    for i, part in enumerate(np.array_split(faces, 2)):
        used, numbers = np.unique(part, return_inverse=True)
        piece = vtkPolyData()
        held = vtkPoints()
        held.SetData(numpy_to_vtk(points[used], deep=True))
        piece.SetPoints(held)
        cells = vtkCellArray()
        corners = numpy_to_vtkIdTypeArray(numbers.reshape(-1).astype(np.int64), deep=True)
        cells.SetData(numpy_to_vtkIdTypeArray(np.arange(0, corners.GetNumberOfTuples() + 1, 3), deep=True), corners)
        piece.SetPolys(cells)
        write(vtkXMLPolyDataWriter(), piece, f"{name}_{i}.vtp")
    with open(os.path.join(scratch, name + ".pvtp"), "w") as file:
        file.write(
            '<VTKFile type="PPolyData" version="1.0"><PPolyData GhostLevel="0"><PPoints>'
            '<PDataArray type="Float32" NumberOfComponents="3"/></PPoints>'
            f'<Piece Source="{name}_0.vtp"/><Piece Source="{name}_1.vtp"/></PPolyData></VTKFile>'
        )


def write_volume(grid, name):
    """A volume mesh as one file, and as two pieces that share the points between them, for two ranks."""
    write(vtkXMLUnstructuredGridWriter(), grid, name + ".vtu")
    for i, part in enumerate(np.array_split(np.arange(grid.GetNumberOfCells()), 2)):
        cells = vtkIdList()
        for number in part:
            cells.InsertNextId(int(number))
        piece = vtkExtractCells()
        piece.SetInputData(grid)
        piece.SetCellList(cells)
        piece.Update()
        piece.GetOutput().GetPointData().RemoveArray("vtkOriginalPointIds")
        piece.GetOutput().GetCellData().RemoveArray("vtkOriginalCellIds")
        write(vtkXMLUnstructuredGridWriter(), piece.GetOutput(), f"{name}_{i}.vtu")
    array = '<PDataArray type="Float64" NumberOfComponents="3"'
    with open(os.path.join(scratch, name + ".pvtu"), "w") as file:
        file.write(
            '<VTKFile type="PUnstructuredGrid" version="1.0"><PUnstructuredGrid GhostLevel="0"><PPointData>'
            f'{array} Name="KneadTestStart"/>{array} Name="velocity"/></PPointData><PPoints>{array}/></PPoints>'
            f'<Piece Source="{name}_0.vtu"/><Piece Source="{name}_1.vtu"/></PUnstructuredGrid></VTKFile>'
        )


def main():
    write_volume(zoo(7), "zoo")
    write_volume(box_of_tetrahedra(12, 0.2), "box")
    write(vtkXMLImageDataWriter(), image(9), "image.vti")
    write(vtkXMLRectilinearGridWriter(), rectilinear(9), "rectilinear.vtr")
    write(vtkXMLStructuredGridWriter(), curvilinear(9), "curvilinear.vts")
    blocks = vtkMultiBlockDataSet()
    for i, block in enumerate([box_of_tetrahedra(5, 0.1), image(6), None, curvilinear(6)]):
        blocks.SetBlock(i, block)
    inner = vtkMultiBlockDataSet()
    inner.SetBlock(0, zoo(3))
    blocks.SetBlock(4, inner)
    write(vtkXMLMultiBlockDataWriter(), blocks, "blocks.vtm")
    parts = vtkPartitionedDataSetCollection()
    parts.SetPartition(0, 0, box_of_tetrahedra(4, 0.1))
    parts.SetPartition(0, 1, box_of_tetrahedra(5, 0.1))
    parts.SetPartition(1, 0, curvilinear(5))
    write(vtkXMLPartitionedDataSetCollectionWriter(), parts, "parts.vtpc")

    turn = '{"tool": "rotate", "center": [0.5, 0.5, 0.5], "axis": [0, 0, 1], "angle_deg": %d, "inner": 0.2, "outer": 0.35}\n'
    sessions = {
        "move": '{"tool": "implicit", "inner": 0.15, "outer": 0.45, "path": [[0.5, 0.5, 0.5], [0.56, 0.52, 0.5]]}\n'
        '{"tool": "rotate", "center": [0.5, 0.5, 0.5], "axis": [0, 0, 1], "angle_deg": 25, "inner": 0.1, "outer": 0.48}\n',
        "invert": turn % 170,
        # Inverts cells, restores them, and ends with others.
        "back": turn % 170 + turn % -340,
        "surface": '{"tool": "paint", "path": [[0, 0, 1], [0.5, 0, 0.9]], "outer": 0.2, "depth": 0.05}\n',
    }
    for name, lines in sessions.items():
        with open(os.path.join(scratch, name + ".knead"), "w") as file:
            file.write('{"knead": 1}\n' + lines)

    def knead(*arguments):
        subprocess.run([os.environ["KNEAD"], *arguments, "-q"], cwd=scratch, check=True)

    knead("make", "torus", "-n", "3000", "-o", "torus.ply")
    knead("deform", "torus.ply", "move.knead", "-o", "moved.ply")
    write_in_pieces("torus.ply", "torus")


main()
