"""A cylinder is turned and moved inside a box of a million tetrahedra: Knead beside four other ways to morph the mesh.

Run: PYTHONPATH=build/release/python /usr/bin/python3 bench/cylinder_bench.py [CELLS [MESH.npz]]. Needs numpy, scipy and
gmsh (Debian: python3-scipy python3-gmsh), which makes the mesh in minutes. CELLS: about so many, by default a million.
MESH.npz: keeps the mesh for the next run.

The cylinder, whose surface is a boundary of the mesh, turns about its middle and then moves; the faces of the box rest.
Each method works in a process of its own. The table has the inverted cells (exact), the least scaled Jacobian, the mean of
|volume ratio - 1|, how far a point of the surfaces is from its place at most, seconds of processor time, and the memory
that it took beside the mesh. FFD and RBF are those of PyGeM by their formulas: Bernstein polynomials on a lattice, fitted to the cylinder by
least squares; and a thin-plate spline through 1,000 points of both surfaces. "Laplace" solves for the displacement with
linear elements by conjugate gradients.
"""

import multiprocessing
import os
import sys
import time

import knead
import numpy as np
from scipy import sparse
from scipy.interpolate import RBFInterpolator
from scipy.sparse.linalg import cg
from scipy.special import comb

RADIUS, LENGTH, ANGLE, SHIFT = 0.15, 0.7, 60, 0.2  # in a box from -1 to 1
INNER = np.hypot(RADIUS, LENGTH / 2) + 1e-6  # of the ball around the cylinder
LATTICE = 9


def mesh(cells):
    import gmsh

    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    gmsh.option.setNumber("Mesh.MeshSizeMax", (8 / (0.12 * cells)) ** (1 / 3) * 0.82)
    box = gmsh.model.occ.addBox(-1, -1, -1, 2, 2, 2)
    cylinder = gmsh.model.occ.addCylinder(0, 0, -LENGTH / 2, 0, 0, LENGTH, RADIUS)
    gmsh.model.occ.cut([(3, box)], [(3, cylinder)])
    gmsh.model.occ.synchronize()
    gmsh.model.mesh.generate(3)
    numbers, places, _ = gmsh.model.mesh.getNodes()
    corners = gmsh.model.mesh.getElementsByType(4)[1].reshape(-1, 4)
    gmsh.finalize()
    used, corners = np.unique(corners, return_inverse=True)
    place = np.empty(int(numbers.max()) + 1, int)
    place[numbers.astype(int)] = np.arange(len(numbers))
    return places.reshape(-1, 3)[place[used.astype(int)]], corners.reshape(-1, 4)


def kept_mesh(cells, path):
    if path and os.path.exists(path):
        with np.load(path) as arrays:
            return arrays["points"], arrays["cells"]
    points, corners = mesh(cells)
    if path:
        np.savez(path, points=points, cells=corners)
    return points, corners


def rigid(points):
    turn = np.radians(ANGLE)
    x, y, z = points.T
    return np.stack([x + SHIFT, np.cos(turn) * y - np.sin(turn) * z, np.sin(turn) * y + np.cos(turn) * z], 1)


def session(points, cells):
    """The turn, and the move, each with the widest transition that fits."""
    turn = knead.Rotate(center=[0, 0, 0], axis=[1, 0, 0], angle_deg=ANGLE, inner=INNER, outer=1.1 * INNER)
    turn = turn.replace(outer=knead.widest_outer(points, cells, turn))
    move = knead.Implicit(path=[[0, 0, 0], [SHIFT, 0, 0]], inner=INNER, outer=1.1 * INNER)
    return [turn, move.replace(outer=knead.widest_outer(knead.deform(points, turn), cells, move))]


def flow(points, cells, surfaces, strokes):
    return knead.deform(points, strokes)


def deform_cells(points, cells, surfaces, strokes):
    return knead.deform_cells(points, cells, strokes)[0]


def ffd(points, cells, surfaces, strokes):
    degree = LATTICE - 1

    def basis(places):
        """The value of each inner control point's polynomial at each place."""
        axes = [
            np.stack([comb(degree, k) * t**k * (1 - t) ** (degree - k) for k in range(1, degree)], 1)
            for t in (places.T + 1) / 2
        ]
        return np.einsum("ni,nj,nk->nijk", *axes).reshape(len(places), -1)

    cylinder = points[surfaces[0]]
    given = basis(cylinder)
    ridge = 1e-6 * np.trace(given.T @ given) / given.shape[1]
    weights = np.linalg.solve(given.T @ given + ridge * np.eye(given.shape[1]), given.T @ (rigid(cylinder) - cylinder))
    return np.concatenate([part + basis(part) @ weights for part in np.array_split(points, 64)])


def rbf(points, cells, surfaces, strokes):
    random = np.random.default_rng(1)
    cylinder, box = (points[random.choice(s, 500, replace=False)] for s in surfaces)
    moves = np.concatenate([rigid(cylinder) - cylinder, np.zeros_like(box)])
    return points + RBFInterpolator(np.concatenate([cylinder, box]), moves, kernel="thin_plate_spline")(points)


def laplace(points, cells, surfaces, strokes):
    a, b, c, d = (points[cells[:, k]] for k in range(4))
    sixfold = np.einsum("ni,ni->n", b - a, np.cross(c - a, d - a))[:, None]
    slopes = [np.cross(d - b, c - b) / sixfold, np.cross(c - a, d - a) / sixfold]
    slopes += [np.cross(d - a, b - a) / sixfold, np.cross(b - a, c - a) / sixfold]
    entries = [(slopes[i] * slopes[j]).sum(1) * np.abs(sixfold[:, 0]) / 6 for i in range(4) for j in range(4)]
    rows = [cells[:, i] for i in range(4) for _ in range(4)]
    columns = [cells[:, j] for _ in range(4) for j in range(4)]
    matrix = sparse.csr_matrix((np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns))))
    moves = np.zeros_like(points)
    moves[surfaces[0]] = rigid(points[surfaces[0]]) - points[surfaces[0]]
    inner = np.setdiff1d(np.arange(len(points)), np.concatenate(surfaces))
    small = matrix[inner][:, inner]
    scale = sparse.diags(1 / small.diagonal())
    for axis in range(3):
        moves[inner, axis] = cg(small, -(matrix[inner] @ moves[:, axis]), tol=1e-8, M=scale)[0]
    return points + moves


def memory(name):
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith(name)) / 1024


def work(method, given, results):
    strokes = session(*given[:2])
    with open("/proc/self/clear_refs", "w") as file:
        file.write("5")  # the peak begins anew
    before = memory("VmRSS:")
    began = time.process_time()
    moved = method(*given, strokes)
    seconds = time.process_time() - began
    results.put((moved, seconds, memory("VmHWM:") - before))


def main():
    began = time.perf_counter()
    points, cells = kept_mesh(float(sys.argv[1]) if len(sys.argv) > 1 else 1e6, sys.argv[2] if len(sys.argv) > 2 else None)
    on_box = (np.abs(np.abs(points) - 1) < 1e-9).any(1)
    radius = np.hypot(points[:, 0], points[:, 1])
    on_cylinder = (np.abs(radius - RADIUS) < 1e-6) & (np.abs(points[:, 2]) < LENGTH / 2 + 1e-6)
    on_cylinder |= (radius < RADIUS) & (np.abs(np.abs(points[:, 2]) - LENGTH / 2) < 1e-6)
    surfaces = [np.flatnonzero(on_cylinder), np.flatnonzero(on_box)]
    place = np.where(on_cylinder[:, None], rigid(points), points)
    quality = knead.check_cells(points, cells)
    print(f"{len(cells):,} tetrahedra, {len(points):,} points, {on_cylinder.sum():,} of them on the cylinder and "
          f"{on_box.sum():,} on the box; least scaled Jacobian {quality['scaled_jacobian'].min():.3f}; made or read in "
          f"{time.perf_counter() - began:.0f} s", flush=True)
    strokes = session(points, cells)
    print("Knead's session:", *strokes)
    print("safe:", knead.safe_until(points, cells, strokes))
    print("| method | inverted | least scaled Jacobian | mean volume change | surfaces off by | processor s | MB |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    context = multiprocessing.get_context("spawn")
    for name, method in [("flow", flow), ("`deform_cells`", deform_cells), ("FFD", ffd), ("RBF", rbf), ("Laplace", laplace)]:
        results = context.Queue()
        process = context.Process(target=work, args=(method, (points, cells, surfaces), results))
        process.start()
        moved, seconds, megabytes = results.get()
        process.join()
        quality = knead.check_cells(moved, cells, before=points)
        off = np.linalg.norm(moved - place, axis=1)[on_box | on_cylinder].max()
        print(f"| {name} | {quality['inverted'].sum():,} | {quality['scaled_jacobian'].min():.3f} "
              f"| {np.abs(quality['volume_ratio'] - 1).mean():.4f} | {off:.1g} | {seconds:.2f} | {megabytes:.0f} |", flush=True)


if __name__ == "__main__":
    main()
