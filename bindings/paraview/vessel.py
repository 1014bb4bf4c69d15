"""Makes the vessel of docs/paraview.md: a curved tube of hexahedra and wedges with the velocity of the flow within.

    pvpython bindings/paraview/vessel.py FOLDER

writes FOLDER/vessel.vtu and FOLDER/bulge.knead, a session that draws its wall out at the bend.
"""

import os
import sys

import numpy as np
from vtkmodules.util.numpy_support import numpy_to_vtk
from vtkmodules.vtkCommonCore import vtkIdList, vtkPoints
from vtkmodules.vtkCommonDataModel import VTK_HEXAHEDRON, VTK_WEDGE, vtkUnstructuredGrid
from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter

ALONG, AROUND, RINGS = 160, 48, 14  # cells
RADIUS = 0.35

SESSION = """{"knead": 1, "note": "The wall of the vessel is drawn out at the bend."}
{"tool": "implicit", "inner": 0.3, "outer": 1.3, "path": [[0, 1.2, 0], [0, 1.42, 0.02]]}
{"tool": "implicit", "inner": 0.28, "outer": 1.1, "path": [[0.12, 1.42, 0], [0.2, 1.6, 0.05]]}
"""


def vessel():
    """Points (n, 3), velocities (n, 3), hexahedra and wedges as numbers of points."""
    angle = np.linspace(-0.75, 0.75, ALONG + 1) * np.pi
    centre = np.stack([np.sin(angle) * 1.1, np.cos(angle) * 0.9 + 0.15, 0.25 * np.sin(2 * angle)], -1)
    along = np.gradient(centre, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    side = np.cross(along, [0, 0, 1])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, along)
    turn = np.linspace(0, 2 * np.pi, AROUND, endpoint=False)
    radius = RADIUS * np.linspace(0, 1, RINGS + 1)[1:]
    points, velocity = [], []
    for c, t, s, u in zip(centre, along, side, up):
        ring = np.cos(turn)[:, None] * s + np.sin(turn)[:, None] * u
        points.append(np.vstack([c, *(c + r * ring for r in radius)]))
        speed = 1 - np.concatenate([[0], np.repeat(radius, AROUND)]) ** 2 / RADIUS**2
        velocity.append(speed[:, None] * t)
    layer = 1 + RINGS * AROUND
    cells = []
    for k in range(ALONG):
        for j in range(AROUND):
            i = (j + 1) % AROUND
            a, b = k * layer, (k + 1) * layer
            cells.append((VTK_WEDGE, [a, a + 1 + j, a + 1 + i, b, b + 1 + j, b + 1 + i]))
            for r in range(RINGS - 1):
                p, q = 1 + r * AROUND, 1 + (r + 1) * AROUND
                cells.append((VTK_HEXAHEDRON, [a + p + j, a + q + j, a + q + i, a + p + i,
                                               b + p + j, b + q + j, b + q + i, b + p + i]))
    return np.vstack(points), np.vstack(velocity), cells


def main(folder):
    points, velocity, cells = vessel()
    grid = vtkUnstructuredGrid()
    held = vtkPoints()
    held.SetData(numpy_to_vtk(points, deep=True))
    grid.SetPoints(held)
    for kind, numbers in cells:
        ids = vtkIdList()
        for number in numbers:
            ids.InsertNextId(int(number))
        grid.InsertNextCell(kind, ids)
    array = numpy_to_vtk(velocity, deep=True)
    array.SetName("velocity")
    grid.GetPointData().SetVectors(array)
    writer = vtkXMLUnstructuredGridWriter()
    writer.SetFileName(os.path.join(folder, "vessel.vtu"))
    writer.SetInputData(grid)
    writer.SetDataModeToBinary()
    writer.Write()
    with open(os.path.join(folder, "bulge.knead"), "w") as file:
        file.write(SESSION)
    print(f"{len(points)} points, {len(cells)} cells")


if __name__ == "__main__":
    main(sys.argv[1])
