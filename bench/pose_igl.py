"""Measures how libigl poses the scenes of pose_bench, with the columns of its table.

    build/release/bench/pose_bench --export FOLDER [MESH...]
    PYTHONPATH=build/release/python python3 bench/pose_igl.py FOLDER

As-rigid-as-possible (Sorkine and Alexa 2007) takes the marked vertices to their places in ten steps of ten iterations
each, biharmonic handles (Botsch and Kobbelt 2004, without details apart) in one. Needs libigl.
"""

import sys
import time
from pathlib import Path

import numpy as np

import knead

try:
    import igl
except ImportError:
    igl = None

ITERATIONS = 10


def stretches(before, after, faces):
    """Returns the least and the greatest singular value of the triangles' maps, and the rms of their logarithms."""
    a, b = before[faces[:, 1]] - before[faces[:, 0]], before[faces[:, 2]] - before[faces[:, 0]]
    twice = np.linalg.norm(np.cross(a, b), axis=1)
    x = np.linalg.norm(a, axis=1)
    y, z = np.einsum("ij,ij->i", a, b) / x, twice / x
    u = (after[faces[:, 1]] - after[faces[:, 0]]) / x[:, None]
    v = (after[faces[:, 2]] - after[faces[:, 0]] - u * y[:, None]) / z[:, None]
    uu, vv, uv = (np.einsum("ij,ij->i", p, q) for p, q in ((u, u), (v, v), (u, v)))
    greatest = np.sqrt((uu + vv) / 2 + np.hypot((uu - vv) / 2, uv))
    least = np.maximum(np.linalg.norm(np.cross(u, v), axis=1) / greatest, 1e-12)
    logs = (np.log(greatest) ** 2 + np.log(least) ** 2) / 2
    return least.min(), greatest.max(), np.sqrt(np.average(logs, weights=twice))


def as_rigid_as_possible(v, f, marked, places):
    data = igl.ARAPData()
    data.max_iter = ITERATIONS
    igl.arap_precomputation(v, f, 3, marked.astype(np.int32), data)
    result = v
    for at in places:
        result = igl.arap_solve(np.ascontiguousarray(at), data, result)
    return result


def biharmonic(v, f, marked, places):
    moved = igl.harmonic(v, f, marked, places[-1] - v[marked], 2)
    return v + moved


def show(path):
    shape = knead.read(path)
    v, f = shape.vertices, shape.triangles.astype(np.int64)
    table = np.loadtxt(path.with_suffix(".csv"), delimiter=",", ndmin=2)
    marked, places = table[:, 0].astype(np.int64), table[:, 1:].reshape(len(table), -1, 3).transpose(1, 0, 2)
    volume = knead.check(v, shape.triangles)["volume"]
    size = np.linalg.norm(np.ptp(v, axis=0))
    for name, way in (("as-rigid-as-possible", as_rigid_as_possible), ("biharmonic", biharmonic)):
        began = time.perf_counter()
        moved = np.ascontiguousarray(way(v, f, marked, places))
        seconds = time.perf_counter() - began
        least, greatest, rms = stretches(v, moved, f)
        found = knead.check(moved, shape.triangles)
        off = np.linalg.norm(moved[marked] - places[-1], axis=1).max() / size
        print(
            f"| {path.stem.replace('__', ', ')} | {len(v)} | {name} | {found['volume'] / volume - 1:+.1e} | {found['self_intersections']} "
            f"| {least:.2f}, {greatest:.2f} | {rms:.4f} | {off:.1e} | {seconds:.2f} |",
            flush=True,
        )


def main():
    if igl is None:
        print("pose_igl: left out: there is no igl", file=sys.stderr)
        return
    print("| scene | vertices | way | volume | crossing pairs | stretch | rms of log stretch | place | seconds |")
    print("| --- | ---: | --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    for path in sorted(Path(sys.argv[1]).glob("*.ply")):
        if path.with_suffix(".csv").exists():
            show(path)


if __name__ == "__main__":
    main()
