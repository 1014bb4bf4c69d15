"""Pulls a bump out of a shape by Knead's Python module and by other methods; prints time, volume and crossings of each.

    PYTHONPATH=build/release/python python3 bench/python_bench.py [SHAPE] [--repeats 5] [--library deform_bench]

SHAPE: a closed mesh; a ball of 437,000 vertices if none is given. --library: the program of `./dev bench` that does the
same job without Python; its times stand in rows of their own. Needs scipy; libigl is used where it is installed.
"""

import argparse
import os
import statistics
import subprocess
import tempfile
import time

import numpy as np

import knead

SIZE = dict(inner=0.02, outer=0.12, length=0.08)  # of the diagonal of the shape


def ball(vertices):
    """Returns vertices and faces of a sphere of radius 1: a grid of latitudes and longitudes with two poles."""
    rows = int(np.sqrt(vertices / 2))
    turn, fall = np.meshgrid(2 * np.pi * np.arange(2 * rows) / (2 * rows), np.pi * np.arange(1, rows) / rows)
    ring = np.stack([np.sin(fall) * np.cos(turn), np.cos(fall), -np.sin(fall) * np.sin(turn)], axis=-1).reshape(-1, 3)
    n = 2 * rows
    a = np.arange(n * (rows - 2)).reshape(rows - 2, n)
    b = np.roll(a, -1, axis=1)
    top, bottom = len(ring), len(ring) + 1
    first, last = np.arange(n), n * (rows - 2) + np.arange(n)
    faces = [np.stack([x.ravel() for x in corners], axis=1) for corners in ((a, a + n, b), (b, a + n, b + n))]
    faces += [np.stack([np.full(n, top), first, np.roll(first, -1)], axis=1)]
    faces += [np.stack([np.full(n, bottom), np.roll(last, -1), last], axis=1)]
    return np.vstack([ring, [[0, 1, 0], [0, -1, 0]]]), np.vstack(faces).astype(np.uint32)


def kelvinlets(v, tip, push, outer):
    """A regularized Kelvinlet of an incompressible material (de Goes and James, 2017), scaled to take the tip by `push`."""
    epsilon = outer / 3

    def move():
        r = v - tip
        far = np.sqrt((r * r).sum(axis=1) + epsilon**2)
        straight = 0.5 / far + 0.5 * epsilon**2 / far**3  # a = 1, b = a / 2: Poisson's ratio 1/2
        along = 0.5 * (r @ push) / far**3
        return v + (straight[:, None] * push + along[:, None] * r) * epsilon

    return move


def rbf(v, tip, push, inner, outer):
    """Thin plate splines through 400 vertices: those within `inner` move, those outside `outer` stay."""
    from scipy.interpolate import RBFInterpolator

    distance = np.linalg.norm(v - tip, axis=1)
    random = np.random.default_rng(1)
    held = random.choice(np.flatnonzero((distance > outer) & (distance < 2 * outer)), 250, replace=False)
    held = np.concatenate([held, random.choice(np.flatnonzero(distance >= 2 * outer), 100, replace=False)])
    within = np.flatnonzero(distance < inner)
    moved = random.choice(within, min(50, len(within)), replace=False)
    centres = np.concatenate([held, moved])
    target = np.zeros((len(centres), 3))
    target[len(held) :] = push
    return lambda: v + RBFInterpolator(v[centres], target, kernel="thin_plate_spline")(v)


def ffd(v, tip, push, outer):
    """Free-form deformation (Sederberg and Parry, 1986), as PyGeM does it: a lattice of 5 x 5 x 5 around the tool."""
    lattice = np.zeros((5, 5, 5, 3))
    lattice[2, 2, 2] = push / 0.375**3  # the weight of the control point in the middle, at the tip

    def move():
        local = (v - tip) / (2 * outer) + 0.5
        inside = np.flatnonzero(((local >= 0) & (local <= 1)).all(axis=1))
        t = local[inside]
        weight = np.stack([c * t**i * (1 - t) ** (4 - i) for i, c in enumerate((1, 4, 6, 4, 1))], axis=2)
        result = v.copy()
        result[inside] += np.einsum("ni,nj,nk,ijkd->nd", *(weight[:, axis] for axis in range(3)), lattice, optimize=True)
        return result

    return move


def in_place(v, session):
    points = v.copy()

    def move():
        points[:] = v
        begin = time.perf_counter(), time.process_time()
        knead.deform(points, session, out=points)
        return points, (time.perf_counter() - begin[0], time.process_time() - begin[1])

    return move


def measures(v):
    """Returns the place that is pulled, the displacement, and the radii of the tool."""
    diagonal = np.linalg.norm(v.max(axis=0) - v.min(axis=0))
    inner, outer, length = (diagonal * SIZE[key] for key in ("inner", "outer", "length"))
    return v[np.argmax(v[:, 1])], np.array([0, length, 0]), inner, outer


def local_pull(v):
    tip, push, inner, outer = measures(v)
    return knead.Implicit(path=[tip, tip + push], inner=inner, outer=outer)


def jobs(v, f):
    """Returns what to time: names and functions that return the new vertices."""
    tip, push, inner, outer = measures(v)
    pull = local_pull(v)
    flow = knead.Flow(pull)
    return {
        "knead.deform, in place": in_place(v, pull),
        "knead.deform, new array": lambda: knead.deform(v, pull),
        "knead.deform, with faces": lambda: knead.deform(v, pull, f),
        "knead.Flow": lambda: flow(v),
        "Kelvinlet, displaced (numpy)": kelvinlets(v, tip, push, outer),
        "FFD, 5x5x5 (numpy)": ffd(v, tip, push, outer),
        "RBF, thin plate, 400 centres (scipy)": rbf(v, tip, push, inner, outer),
    }


class Library:
    """The same job without Python, by the program deform_bench."""

    def __init__(self, program, v, f, folder):
        mesh, session = os.path.join(folder, "shape.off"), os.path.join(folder, "pull.knead")
        with open(mesh, "w") as out:
            print("OFF", len(v), len(f), 0, file=out)
            np.savetxt(out, v, "%.17g")
            np.savetxt(out, np.insert(f, 0, 3, axis=1), "%d")
        knead.Session([local_pull(v)]).write(session)
        self.process = subprocess.Popen([program, mesh, session], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)

    def job(self, name, v):
        def ask():
            print(name, file=self.process.stdin, flush=True)
            wall, processor = (float(x) / 1000 for x in self.process.stdout.readline().split())
            return v, (wall, processor)

        return ask


def print_igl(v):
    """Prints what libigl's own Kelvinlets take for a few vertices: it integrates each by itself."""
    try:
        import igl
    except ImportError:
        return
    tip, push, _, outer = measures(v)
    near = v[np.argsort(np.linalg.norm(v - tip, axis=1))[:200]]
    begin = time.perf_counter()
    igl.kelvinlets(near, tip, push, np.zeros((3, 3)), outer / 3, 1.0)
    print(f"igl.kelvinlets: {1000 * (time.perf_counter() - begin) / len(near):.1f} ms for each of {len(near)} vertices")


def timed(job):
    begin = time.perf_counter(), time.process_time()
    result = job()
    spent = time.perf_counter() - begin[0], time.process_time() - begin[1]
    return result if isinstance(result, tuple) else (result, spent)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("shape", nargs="?", help="file of a closed mesh")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--library", help="the program deform_bench")
    options = parser.parse_args()
    if options.shape:
        shape = knead.read(options.shape)
        v, f = np.array(shape.vertices), shape.faces
    else:
        v, f = ball(437_000)
    before = knead.check(v, f)
    print(f"{options.shape or 'ball'}: {len(v)} vertices, {before['self_intersections']} crossings, "
          f"{os.cpu_count()} cores, knead {knead.__version__}, numpy {np.__version__}")  # fmt: skip
    all_jobs = jobs(v, f)
    folder = tempfile.TemporaryDirectory()
    if options.library:
        library = Library(options.library, v, f, folder.name)
        moved = knead.deform(v, local_pull(v))
        all_jobs = {f"the library, {name}": library.job(name, moved) for name in ("advect", "replay")} | all_jobs
    times, results = {name: [] for name in all_jobs}, {}
    for _ in range(options.repeats):  # in turn, so that other work on the machine meets all
        for name, job in all_jobs.items():
            result, spent = timed(job)
            times[name].append(spent)
            results[name] = result
    print("| | ms | ms of processor time | volume error | new crossings |\n| --- | ---: | ---: | ---: | ---: |")
    for name, spent in times.items():
        wall, processor = (1000 * statistics.median(column) for column in zip(*spent))
        after = knead.check(results[name], f)
        error = after["volume"] / before["volume"] - 1
        crossings = after["self_intersections"] - before["self_intersections"]
        print(f"| {name} | {wall:.1f} | {processor:.1f} | {error:+.1e} | {crossings} |", flush=True)
    print_igl(v)


if __name__ == "__main__":
    main()
