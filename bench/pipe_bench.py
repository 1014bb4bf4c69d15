"""Bends a pipe full of cells by Knead and by others.

Run: PYTHONPATH=build/release/python /usr/bin/python3 bench/pipe_bench.py [METHOD ...]. Needs numpy and scipy, and for the
method physicsnemo NVIDIA's module of that name, which runs on the CPU. It prints a table. The table has the number of
inverted cells, the greatest non-orthogonality in degrees, the distance of the wall from its place, and seconds.

Every method is to take the wall where the flow takes it. The radial basis functions of scipy and PhysicsNeMo and
PhysicsNeMo's Shepard morph get 900 points of the wall. The lattice, Bernstein polynomials as in PyGeM, gets the best
displacements for all points.
"""

import sys
import time

import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.special import comb

import knead

RADIUS, LENGTH, ACROSS, ALONG = 0.5, 8.0, 16, 96
CONTROLS = 900
LATTICE = (12, 5, 5)


def pipe():
    """Points, hexahedra, and which points lie on the wall."""
    side = np.linspace(-1, 1, ACROSS + 1)
    x, u, v = np.meshgrid(np.linspace(-LENGTH / 2, LENGTH / 2, ALONG + 1), side, side, indexing="ij")
    y, z = u * np.sqrt(1 - v * v / 2), v * np.sqrt(1 - u * u / 2)  # a square becomes a disc
    points = np.column_stack([x.ravel(), RADIUS * y.ravel(), RADIUS * z.ravel()])
    number = np.arange(x.size).reshape(x.shape)
    corner = lambda i, j, k: number[i : ALONG + i, j : ACROSS + j, k : ACROSS + k].ravel()
    cells = np.column_stack([corner(*c) for c in [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]])
    return points, cells, np.maximum(np.abs(u), np.abs(v)).ravel() == 1


def bernstein(points):
    low, size = points.min(axis=0), np.ptp(points, axis=0)
    factors = []
    for axis, count in enumerate(LATTICE):
        t = ((points[:, axis] - low[axis]) / size[axis])[:, None]
        i = np.arange(count)
        factors.append(comb(count - 1, i) * t**i * (1 - t) ** (count - 1 - i))
    return np.einsum("ni,nj,nk->nijk", *factors).reshape(len(points), -1)


def by_physicsnemo(points, controls, displacements, radius=None):
    import torch
    from physicsnemo.nn.functional.geometry.deform import morph_points, radial_basis_function_deform_points

    arrays = [torch.from_numpy(np.ascontiguousarray(a)) for a in (points, controls, displacements)]
    moved = radial_basis_function_deform_points(*arrays) if radius is None else morph_points(*arrays, radius=radius)
    return moved.numpy()


def main():
    points, cells, is_wall = pipe()
    chosen = np.random.default_rng(1).choice(np.flatnonzero(is_wall), CONTROLS, replace=False)
    print("| angle | method | inverted | non-orthogonality | wall | s |\n| ---: | --- | ---: | ---: | ---: | ---: |")
    for angle in (0, 60, 120, 165):
        session = knead.Session([knead.Bend(center=[0, 0, 0], axis=[0, 1, 0], normal=[-1, 0, 0], width=3, angle_deg=angle)])
        target = knead.deform(points, session, precision="float64", relative_tolerance=1e-9)
        moves = target - points
        fit = lambda basis: basis @ np.linalg.lstsq(basis, moves, rcond=None)[0]
        methods = {
            "deform": lambda: knead.deform(points, session),
            "deform_cells": lambda: knead.deform_cells(points, cells, session)[0],
            "scipy": lambda: points + RBFInterpolator(points[chosen], moves[chosen], kernel="thin_plate_spline")(points),
            "ffd": lambda: points + fit(bernstein(points)),
            "physicsnemo": lambda: by_physicsnemo(points, points[chosen], moves[chosen]),
            "physicsnemo morph": lambda: by_physicsnemo(points, points[chosen], moves[chosen], radius=2 * RADIUS),
        }
        for name in sys.argv[1:] or methods:
            begin = time.perf_counter()
            try:
                moved = methods[name]()
            except ImportError as error:
                print(f"| {angle} | {name} | fails: {error} |")
                continue
            seconds = time.perf_counter() - begin
            found = knead.check_cells(moved, cells)
            wall = np.linalg.norm((moved - target)[is_wall], axis=1).max()
            print(f"| {angle} | {name} | {found['inverted'].sum():,} of {len(cells):,} | {found['non_orthogonality_deg'].max():.1f} | {wall:.1e} | {seconds:.2f} |", flush=True)


main()
