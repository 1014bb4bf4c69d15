"""Morphs two meshes with boundary layers by Knead and by others, and lets OpenFOAM's checkMesh judge the cells.

Run: PYTHONPATH=build/release/python /usr/bin/python3 bench/engineers_bench.py KNEAD FOLDER [METHOD ...]. FOLDER holds the
meshes of engineers_meshes.py, and takes the results. Needs numpy, scipy, OpenFOAM (Debian: openfoam), and for the
method pygem the module of github.com/mathLab/PyGeM. Prints a table: inverted cells, greatest non-orthogonality and
skewness, the greatest change of the height of the first layer, and seconds.

Each method gives the points of the moved wall the same places, as far as it can: the flow's. The other methods get the
motion of that wall and of the walls that stay; the radial basis functions a part of their points.
"""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import time
import types

import numpy as np
import stiff_grid

_CONTROL_POINTS = 900
# The mesh, the patch that moves, those that stay and those that slide, the walls of the session, and its strokes.
_SCENES = {
    "rod": ("rod", "rod", ["wall", "inlet", "outlet"], [], '{"patch": "rod", "layers": true, "width": 0.06}', '{"tool": "implicit", "path": [[0, 0, 2], [0.1, 0, 2]], "inner": 0.4, "outer": 0.98}'),
    "whole rod": ("rod", "rod", ["wall"], ["inlet", "outlet"], '{"patch": "wall", "hold": true, "width": 0.02}, {"patch": "rod", "layers": true, "width": 0.06}',
                  stiff_grid.strokes(shift=0.1, rod=0.25, layers=0.272, pipe=1.0, length=4.0, spacing=0.1)),
    "airfoil": ("airfoil", "airfoil", ["far"], ["front", "back"], '{"patch": "airfoil", "layers": true, "width": 0.5}', '{"tool": "rotate", "center": [0.25, 0, 0.05], "axis": [0, 0, 1], "angle_deg": -15, "inner": 1.0, "outer": 3.5}'),
}
_HEAD = "FoamFile {{ version 2.0; format ascii; class {}; object {}; }}\n"


class Mesh:
    """A file of gmsh's version 2.2: its points, and its elements by type with their groups."""

    def __init__(self, path):
        self.text = path.read_text()
        self.begin = self.text.index("$Nodes\n") + 7
        self.end = self.text.index("$EndNodes")
        rows = self.text[self.begin : self.end].split("\n", 1)[1]
        self.points = np.array(rows.split(), float).reshape(-1, 4)[:, 1:]
        names = dict(re.findall(r'\d+ (\d+) "(\w+)"', self.text))
        self.patches, self.cells, self.faces = {}, {}, {}
        found = {}
        for line in self.text[self.text.index("$Elements\n") + 10 :].splitlines()[1:-1]:
            row = line.split()
            found.setdefault((int(row[1]), row[3]), []).append(row[5:])
        for (kind, group), nodes in found.items():
            nodes = np.array(nodes, int) - 1
            if kind in (5, 6):
                self.cells[kind] = nodes
            else:
                self.patches.setdefault(names[group], []).append(nodes.ravel())
                self.faces[names[group], kind] = nodes
        self.patches = {name: np.unique(np.concatenate(parts)) for name, parts in self.patches.items()}

    def write(self, path, points):
        rows = "".join(f"{i} {x!r} {y!r} {z!r}\n" for i, (x, y, z) in enumerate(points.tolist(), 1))
        path.write_text(self.text[: self.begin] + f"{len(points)}\n" + rows + self.text[self.end :])

    def first_layer(self, patch):
        """Returns the hexahedra at the patch: their faces there, and the nodes over these, both (n, 4)."""
        faces, hexahedra = self.faces[patch, 3], self.cells[5]
        on_wall = np.isin(hexahedra, faces).sum(axis=1) == 4
        sides = [(0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
        opposite = [(3, 2, 6, 7), (0, 3, 7, 4), (1, 0, 4, 5), (2, 1, 5, 6)]
        below, above = [], []
        for cell in hexahedra[on_wall]:
            for side, other in zip(sides, opposite):
                if np.isin(cell[list(side)], faces).all():
                    below.append(cell[list(side)])
                    above.append(cell[list(other)])
        return np.array(below), np.array(above)


def heights(points, layer):
    below, above = (points[nodes] for nodes in layer)
    normal = np.cross(below[:, 2] - below[:, 0], below[:, 3] - below[:, 1])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    return np.abs(((above - below) * normal[:, None]).sum(axis=2).mean(axis=1))


def foam_case(folder, mesh_file):
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "system").mkdir(parents=True)
    (folder / "constant").mkdir()
    (folder / "0").mkdir()
    (folder / "system/controlDict").write_text(
        _HEAD.format("dictionary", "controlDict") + "application moveDynamicMesh; startFrom startTime; startTime 0; stopAt endTime; endTime 1;"
        " deltaT 1; writeControl timeStep; writeInterval 1; writePrecision 17; writeFormat ascii;\n")
    (folder / "system/fvSchemes").write_text(
        _HEAD.format("dictionary", "fvSchemes") + "ddtSchemes { default Euler; } gradSchemes { default Gauss linear; } divSchemes { default none; }"
        " laplacianSchemes { default Gauss linear corrected; } interpolationSchemes { default linear; } snGradSchemes { default corrected; }\n")
    (folder / "system/fvSolution").write_text(
        _HEAD.format("dictionary", "fvSolution")
        + "solvers { \"cellDisplacement.*\" { solver GAMG; smoother GaussSeidel; tolerance 1e-10; relTol 0; } }\nPIMPLE { nCorrectors 1; }\n")
    run(["gmshToFoam", "-case", folder, mesh_file])


def run(command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"{command[0]}: {(done.stdout + done.stderr)[-600:]}")
    return done.stdout


def foam_points(case):
    text = (case / "constant/polyMesh/points").read_text()
    return np.array([row.split() for row in re.findall(r"^\(([^()]+)\)$", text, re.M)], float)


class Judge:
    """checkMesh for one mesh. gmshToFoam turns round what it takes for inverted, so it sees the mesh before only."""

    def __init__(self, folder, mesh):
        from scipy.spatial import cKDTree

        self.case = folder / "judged"
        mesh.write(folder / "before.msh", mesh.points)
        foam_case(self.case, folder / "before.msh")
        self.index = cKDTree(mesh.points).query(foam_points(self.case))[1]

    def __call__(self, points):
        """Returns the number of inverted cells and of wrong pyramids, the greatest non-orthogonality and skewness."""
        rows = "\n".join(f"({x!r} {y!r} {z!r})" for x, y, z in points[self.index].tolist())
        (self.case / "constant/polyMesh/points").write_text(_HEAD.format("vectorField", "points") + f"{len(self.index)}\n(\n{rows}\n)\n")
        log = subprocess.run(["checkMesh", "-case", self.case], capture_output=True, text=True, check=False).stdout
        found = [re.search(text, log) for text in (r"negative volume cells: (\d+)", r"Error in face pyramids: (\d+)", r"non-orthogonality Max: ([-+.\de]+)", r"[Mm]ax skewness = ([-+.\de]+)")]
        return [float(match[1]) if match else 0 for match in found]


def by_flow(mesh, folder, stroke, knead, walls=""):
    (folder / "one.knead").write_text(f'{{"knead": 1{walls}}}\n{stroke}\n')
    mesh.write(folder / "before.msh", mesh.points)
    run([knead, "deform", folder / "before.msh", folder / "one.knead", "--precision", "double", "--tolerance", "1e-9", "-q", "-o", folder / "after.msh"])
    return Mesh(folder / "after.msh").points


def by_cells(mesh, stroke):
    import knead

    wedges = mesh.cells[6][:, [0, 2, 1, 3, 5, 4]]
    blocks = [types.SimpleNamespace(type="hexahedron", data=mesh.cells[5]), types.SimpleNamespace(type="wedge", data=wedges)]
    session = knead.Session.parse('{"knead": 1}\n' + stroke + "\n")
    return knead.deform_cells(mesh.points, blocks, session, precision="float64", relative_tolerance=1e-9)[0]


def control_points(mesh, moved, still):
    random = np.random.default_rng(1)
    chosen = [random.permutation(mesh.patches[name])[: _CONTROL_POINTS // 2 if name == moved else _CONTROL_POINTS // 2 // len(still)] for name in [moved, *still]]
    return np.unique(np.concatenate(chosen))


def by_scipy(mesh, target, moved, still):
    from scipy.interpolate import RBFInterpolator

    control = control_points(mesh, moved, still)
    return mesh.points + RBFInterpolator(mesh.points[control], target[control] - mesh.points[control], kernel="thin_plate_spline")(mesh.points)


def by_pygem(mesh, target, moved, still):
    from pygem import RBF

    control = control_points(mesh, moved, still)
    rbf = RBF(original_control_points=mesh.points[control], deformed_control_points=target[control], func="thin_plate_spline", radius=1.0)
    return rbf(mesh.points)


def by_foam(mesh, folder, target, scene):
    """displacementLaplacian with the diffusivity of the inverse distance, squared."""
    from scipy.spatial import cKDTree

    _, moved, still, sliding, _, _ = scene
    mesh.write(folder / "before.msh", mesh.points)
    case = folder / "laplacian"
    foam_case(case, folder / "before.msh")
    index = cKDTree(mesh.points).query(foam_points(case))[1]
    faces = [[int(v) for v in row.split()] for row in re.findall(r"^\d+\(([\d ]+)\)$", (case / "constant/polyMesh/faces").read_text(), re.M)]
    entry = re.search(rf"\b{moved}\s*{{[^}}]*nFaces\s+(\d+);[^}}]*startFace\s+(\d+);", (case / "constant/polyMesh/boundary").read_text())
    order = list(dict.fromkeys(v for face in faces[int(entry[2]) : int(entry[2]) + int(entry[1])] for v in face))
    motion = (target - mesh.points)[index[order]]
    rows = "\n".join(f"({x!r} {y!r} {z!r})" for x, y, z in motion.tolist())
    fields = {moved: f"type fixedValue; value nonuniform List<vector> {len(order)} (\n{rows}\n);"}
    fields.update({name: "type fixedValue; value uniform (0 0 0);" for name in still})
    fields.update({name: "type slip;" for name in sliding})
    (case / "0/pointDisplacement").write_text(
        _HEAD.format("pointVectorField", "pointDisplacement") + "dimensions [0 1 0 0 0 0 0]; internalField uniform (0 0 0);\nboundaryField {\n"
        + "".join(f"{name} {{ {value} }}\n" for name, value in fields.items()) + "}\n")
    (case / "constant/dynamicMeshDict").write_text(
        _HEAD.format("dictionary", "dynamicMeshDict") + 'dynamicFvMesh dynamicMotionSolverFvMesh; motionSolverLibs ("libfvMotionSolvers.so");\n'
        f"motionSolver displacementLaplacian; displacementLaplacianCoeffs {{ diffusivity quadratic inverseDistance ({moved}); }}\n")
    begin = time.perf_counter()
    run(["moveDynamicMesh", "-case", case])
    seconds = time.perf_counter() - begin
    text = (case / "1/polyMesh/points").read_text()
    moved_points = np.array([row.split() for row in re.findall(r"^\(([^()]+)\)$", text, re.M)], float)
    result = np.empty_like(mesh.points)
    result[index] = moved_points
    return result, seconds


def main():
    os.environ.setdefault("WM_PROJECT_DIR", "/usr/share/openfoam")
    knead, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    methods = sys.argv[3:] or ["flow", "layers", "deform_cells", "scipy", "pygem", "displacementLaplacian"]
    print("| mesh | method | inverted | wrong pyramids | non-orthogonality | skewness | first height | s |\n| --- | --- | --- | --- | --- | --- | --- | --- |")
    for name, scene in _SCENES.items():
        file, moved, still, _, walls, stroke = scene
        mesh = Mesh(folder / f"{file}.msh")
        layer = mesh.first_layer(moved)
        before = heights(mesh.points, layer)
        target = by_flow(mesh, folder, stroke, knead)
        judge = Judge(folder, mesh)
        calls = {
            "flow": lambda: by_flow(mesh, folder, stroke, knead),
            "layers": lambda: by_flow(mesh, folder, stroke, knead, f', "walls": [{walls}]'),
            "deform_cells": lambda: by_cells(mesh, stroke),
            "scipy": lambda: by_scipy(mesh, target, moved, still),
            "pygem": lambda: by_pygem(mesh, target, moved, still),
            "displacementLaplacian": lambda: by_foam(mesh, folder, target, scene),
        }
        for method in ["before", *methods]:
            begin = time.perf_counter()
            try:
                result = mesh.points if method == "before" else calls[method]()
            except (RuntimeError, ImportError, MemoryError) as error:
                print(f"| {name} | {method} | fails: {str(error)[-200:]!r} |", flush=True)
                continue
            seconds = time.perf_counter() - begin
            points, seconds = result if isinstance(result, tuple) else (result, seconds)
            inverted, pyramids, angle, skewness = judge(points)
            change = np.abs(heights(points, layer) / before - 1).max()
            print(f"| {name} | {method} | {inverted:,.0f} | {pyramids:,.0f} | {angle:.1f} | {skewness:.2f} | {change:.2e} | {seconds:.1f} |", flush=True)


main()
