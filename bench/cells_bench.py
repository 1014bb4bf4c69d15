"""Deforms a volume mesh of 477,000 tetrahedra by the flow alone, by deform_cells and by a radial basis function.

Run: PYTHONPATH=build/release/python python3 bench/cells_bench.py [--no-rbf]. Needs numpy, and scipy for the thin-plate
RBF through 600 points: 300 in the inner ball, which move with it, and 300 from the outer sphere on, which stay. Prints
a table: inverted cells, least scaled Jacobian, mean of |volume ratio - 1|, seconds, and seconds of processor time.
"""

import sys
import time

import knead
import numpy as np

_SIDE = 44  # points on each edge of the unit box
_JITTER = 0.2  # of the distance between points


def jittered_box():
    axis = np.linspace(-0.5, 0.5, _SIDE)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1)
    points[1:-1, 1:-1, 1:-1] += np.random.default_rng(1).uniform(-_JITTER, _JITTER, (_SIDE - 2,) * 3 + (3,)) / (_SIDE - 1)
    number = np.arange(_SIDE**3).reshape((_SIDE,) * 3)
    n = _SIDE - 1
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    boxes = np.stack([number[i : n + i, j : n + j, k : n + k].ravel() for i, j, k in corners], 1)
    ways = [(0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6)]
    return points.reshape(-1, 3), np.concatenate([boxes[:, way] for way in ways])


def turn(degrees):
    angle = np.radians(degrees)
    matrix = np.array([[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]])
    stroke = knead.Rotate(center=[0, 0, 0], axis=[0, 0, 1], angle_deg=degrees, inner=0.12, outer=0.42)
    return stroke, 0.12, 0.42, lambda p: p @ matrix.T


def move(length):
    stroke = knead.Implicit(path=[[0, 0, 0], [length, 0, 0]], inner=0.1, outer=0.24)
    return stroke, 0.1, 0.24, lambda p: p + [length, 0, 0]


def rbf(points, inner, outer, rigid):
    from scipy.interpolate import RBFInterpolator

    random = np.random.default_rng(2)
    distance = np.linalg.norm(points, axis=1)
    ball = points[random.choice(np.flatnonzero(distance < inner), 300)]
    rest = points[random.choice(np.flatnonzero(distance > max(outer, np.linalg.norm(rigid(np.zeros((1, 3)))) + inner)), 300)]
    given = np.unique(np.concatenate([ball, rest]), axis=0)
    moves = np.where(np.linalg.norm(given, axis=1)[:, None] < inner, rigid(given) - given, 0)
    return points + RBFInterpolator(given, moves, kernel="thin_plate_spline")(points)


def row(scene, method, seconds, quality, more=""):
    change = np.abs(quality["volume_ratio"] - 1).mean()
    least = quality["scaled_jacobian"].min()
    print(f"| {scene} | {method} | {quality['inverted'].sum():,} | {least:.3f} | {change:.4f} | {seconds[0]:.2f} | {seconds[1]:.2f} |{more}", flush=True)


def timed(work):
    begin = time.perf_counter(), time.process_time()
    result = work()
    return (time.perf_counter() - begin[0], time.process_time() - begin[1]), result


def main():
    points, cells = jittered_box()
    scenes = {"turned by 60 degrees": turn(60), "turned by 90 degrees": turn(90), "moved by 0.1": move(0.1), "moved by 0.2": move(0.2)}
    print(f"{len(cells):,} tetrahedra, {len(points):,} points")
    print("| scene | method | inverted | least scaled Jacobian | mean volume change | s | processor s |\n| --- | --- | --- | --- | --- | --- | --- |")
    for scene, (stroke, inner, outer, rigid) in scenes.items():
        seconds, moved = timed(lambda stroke=stroke: knead.deform(points, stroke))
        row(scene, "flow", seconds, knead.check_cells(moved, cells, before=points))
        seconds, (moved, report) = timed(lambda stroke=stroke: knead.deform_cells(points, cells, stroke))
        row(scene, "deform_cells", seconds, knead.check_cells(moved, cells, before=points), f" {report['freed']} freed, {report['parts']} parts")
        if "--no-rbf" not in sys.argv:
            seconds, moved = timed(lambda *_, a=(inner, outer, rigid): rbf(points, *a))
            row(scene, "thin-plate RBF", seconds, knead.check_cells(moved, cells, before=points))


main()
