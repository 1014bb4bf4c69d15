"""Fits a shape to itself deformed by a hidden session: by `knead fit`, thin plate splines and Gaussian kernels.

    PYTHONPATH=build/release/python python3 bench/fit_bench.py [SHAPE...] [--knead build/release/knead]
        [--seeds 1] [--moves 6 20] [--landmarks 20] [--loops-up-to 12000]

SHAPE: closed meshes; a procedural hand of 8000 vertices if none is given. A hidden session is four random strokes of
bend, twist, pull, ball and pins, scaled so that the farthest point moves by so many percent of the diagonal. Landmarks
are vertices, each the farthest from those before it. All methods get the same pairs. Those named `surface` then match
the whole surfaces, in the same levels and with the same number of pins as Knead:

- knead: `knead fit`, divergence-free kernels; strokes are remeshed where triangles would cross
- gauss: a scalar Gaussian kernel for each coordinate, integrated over the pins' straight lines: smooth and invertible,
  but it does not keep volume
- spline: scipy's RBFInterpolator with the kernel thin_plate_spline, which moves the vertices at once

Distances are those of the vertices of each shape from the other surface, in percent of the source's diagonal. Loops in
numpy skip shapes above --loops-up-to vertices. Needs scipy.
"""

import argparse
import json
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.interpolate import RBFInterpolator
from scipy.spatial import cKDTree

import knead

FINER = 0.7  # radius of a level, of the one before
SPACING = 0.25  # of pins, in radii
ROUNDS = 8
WORTHWHILE = 0.98
SMOOTHNESS = 0.003


def unit(a):
    return a / np.maximum(np.linalg.norm(a, axis=-1, keepdims=True), 1e-300)


def diagonal(v):
    return np.linalg.norm(np.ptp(v, axis=0))


def hidden_strokes(random, v, strength):
    size = diagonal(v)
    strokes = []
    for kind in random.permutation(["bend", "twist", "pull", "ball", "pins"])[:4]:
        p, axis = v[random.integers(len(v))], unit(random.normal(size=3))
        push = axis * strength * random.uniform(0.5, 1) * size
        if kind == "bend":
            middle, normal = 0.5 * (np.median(v, axis=0) + p), unit(np.cross(axis, random.normal(size=3)))
            angle = strength * random.uniform(30, 60)
            strokes.append(knead.Bend(center=middle, axis=axis, normal=normal, width=0.4 * size, angle_deg=angle))
        elif kind == "twist":
            rate = strength * random.uniform(-120, 120) / size
            strokes.append(
                knead.Twist(center=v.mean(0), axis=axis, rate_deg=rate, inner=-0.3 * size, outer=0.3 * size)
            )
        elif kind in ("pull", "ball"):
            is_pull = kind == "pull"
            r, part, more = (random.uniform(0.1, 0.2), 0.3, 2) if is_pull else (random.uniform(0.26, 0.52), 0.4, 1)
            outer = r * size + more * strength * size
            strokes.append(knead.Implicit(path=[p, p + push], inner=part * r * size, outer=outer))
        else:
            places = v[random.integers(len(v), size=12)]
            moves = 0.3 * strength * size * random.normal(size=(12, 3))
            strokes.append(knead.Pins(points=places, to=places + moves, radius=0.4 * size))
    return strokes


def hide(v, seed, percent):
    strength = 0.006 * percent
    for _ in range(8):
        moved = v
        for stroke in hidden_strokes(np.random.default_rng(seed), v, strength):
            moved = knead.deform(moved, stroke)
        farthest = 100 * np.linalg.norm(moved - v, axis=1).max() / diagonal(v)
        if abs(farthest / percent - 1) < 0.03:
            break
        strength *= percent / farthest
    return moved


def farthest_points(points, count, first=(), spacing=0.0):
    chosen, distance = [], np.full(len(points), np.inf)
    for place in first:
        distance = np.minimum(distance, np.linalg.norm(points - place, axis=1))
    while len(chosen) < count and distance.max() > spacing:
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return chosen


def normals_of(v, t):
    weighted = np.cross(v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]])
    sums = np.zeros_like(v)
    for corner in range(3):
        np.add.at(sums, t[:, corner], weighted)
    return unit(sums)


def volume(v, t):
    return np.einsum("ij,ij->", v[t[:, 0]], np.cross(v[t[:, 1]], v[t[:, 2]])) / 6


def on_triangle(p, a, b, c):
    """Returns the barycentric coordinates of the nearest points of triangles, and their distances."""
    ab, ac, ap = b - a, c - a, p - a
    def dot(x, y):
        return np.einsum("...i,...i->...", x, y)

    def part(x, y):
        return np.clip(dot(x, y) / np.maximum(dot(y, y), 1e-300), 0, 1)[..., None]

    normal = np.cross(ab, ac)
    area = np.maximum(dot(normal, normal), 1e-300)
    w = dot(np.cross(ab, ap), normal) / area
    u = dot(np.cross(ap, ac), normal) / area
    best = np.stack([1 - u - w, u, w], axis=-1)
    outside = (best < 0).any(axis=-1)
    corners = np.stack([a, b, c])
    distance = np.linalg.norm(np.einsum("...k,k...i->...i", best, corners) - p, axis=-1)
    distance = np.where(outside, np.inf, distance)
    s, zero = [part(ap, ab), part(p - b, c - b), part(ap, ac)], np.zeros(p.shape[:-1] + (1,))
    for weights in (
        np.concatenate([1 - s[0], s[0], zero], -1),
        np.concatenate([zero, 1 - s[1], s[1]], -1),
        np.concatenate([1 - s[2], zero, s[2]], -1),
    ):
        d = np.linalg.norm(np.einsum("...k,k...i->...i", weights, corners) - p, axis=-1)
        best = np.where((d < distance)[..., None], weights, best)
        distance = np.minimum(d, distance)
    return best, distance


class Surface:
    """Nearest points, looked for on the 24 triangles whose centres are nearest."""

    def __init__(self, v, t):
        self.v, self.t, self.normals = v, t, normals_of(v, t)
        self.tree = cKDTree(v[t].mean(axis=1))

    def closest(self, points):
        near = self.t[self.tree.query(points, 24)[1]]  # (n, 24, 3)
        corners = [self.v[near[..., k]] for k in range(3)]
        weights, distance = on_triangle(np.repeat(points[:, None], 24, axis=1), *corners)
        best = (np.arange(len(points)), distance.argmin(axis=1))
        t, w = near[best], weights[best][..., None]
        return (self.v[t] * w).sum(axis=1), unit((self.normals[t] * w).sum(axis=1)), distance[best]

    def samples(self, count):
        a, b, c = (self.v[self.t[:, k]] for k in range(3))
        upto = np.cumsum(np.linalg.norm(np.cross(b - a, c - a), axis=1))
        i = np.arange(count)
        face = np.searchsorted(upto, upto[-1] * (i + 0.5) / count).clip(0, len(upto) - 1)
        uv = np.stack([i * 0.7548776662466927 % 1, i * 0.5698402909980532 % 1], axis=1)
        uv = np.where((uv.sum(axis=1) > 1)[:, None], 1 - uv, uv)
        w = np.stack([1 - uv.sum(axis=1), uv[:, 0], uv[:, 1]], axis=1)[..., None]
        t = self.t[face]
        return (self.v[t] * w).sum(axis=1), unit((self.normals[t] * w).sum(axis=1))


def distances(v, faces, target, t):
    return np.concatenate([Surface(target, t).closest(v)[2], Surface(v, faces).closest(target)[2]])


def gauss(a, b, radius):
    square = (a * a).sum(axis=1)[:, None] + (b * b).sum(axis=1) - 2 * a @ b.T
    return np.exp(-4.5 * np.maximum(square, 0) / radius**2)  # a deviation of a third of the radius


def flow(v, points, to, radius, steps=8):
    """Runge and Kutta's method of fourth order; the pins go in straight lines."""
    motions = to - points

    def velocity(x, at):
        pins = points + at * motions
        kernel = gauss(pins, pins, radius) + 1e-9 * np.eye(len(pins))
        return gauss(x, pins, radius) @ np.linalg.solve(kernel, motions)

    h = 1 / steps
    for k in range(steps):
        k1 = velocity(v, k * h)
        k2 = velocity(v + 0.5 * h * k1, (k + 0.5) * h)
        k3 = velocity(v + 0.5 * h * k2, (k + 0.5) * h)
        k4 = velocity(v + h * k3, (k + 1) * h)
        v = v + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    return v


def spline(v, points, to, radius):
    return v + RBFInterpolator(points, to - points, kernel="thin_plate_spline")(v)


def matches(surface, target, count):
    """As src/fit/fit_matches.cpp."""
    at, own = surface.samples(count)
    places, theirs, far = target.closest(at)
    at2, theirs2 = target.samples(count)
    places2, own2, far2 = surface.closest(at2)
    mean = np.concatenate([far, far2]).mean()
    at, to = np.concatenate([at, places2]), np.concatenate([places, at2])
    own, theirs = np.concatenate([own, own2]), np.concatenate([theirs, theirs2])
    cosine = (own * theirs).sum(axis=1)
    sure = 1 / (1 + (np.linalg.norm(to - at, axis=1) / (8 * mean)) ** 2)
    direction = unit(own + theirs)
    by = ((to - at) * direction).sum(axis=1)
    keep = cosine > 0.2
    return mean, at[keep], direction[keep], by[keep], (cosine * sure)[keep] ** 2


def pin_motions(pins, landmarks, at, direction, by, weight, radius):
    """As src/fit/fit_pins.cpp, with the Gaussian kernel."""
    n = len(pins)
    rows = gauss(at, pins, radius)[:, :, None] * direction[:, None, :]
    rows = rows.reshape(len(at), 3 * n)
    weight = weight * n / len(at)
    own = np.kron(gauss(pins, pins, radius), np.eye(3))
    held = own[: 3 * len(landmarks)]
    left = rows.T @ (weight[:, None] * rows) + SMOOTHNESS * own + 1e3 * held.T @ held
    right = rows.T @ (weight * by) + 1e3 * held.T @ (landmarks - pins[: len(landmarks)]).ravel()
    motions = (own @ np.linalg.solve(left + 1e-9 * np.eye(3 * n), right)).reshape(n, 3)
    apart = np.linalg.norm(pins[:, None] - pins, axis=2) + np.eye(n)
    strain = np.linalg.norm(motions[:, None] - motions, axis=2) / apart
    strain[: len(landmarks), : len(landmarks)] = 0
    scale = max(1, strain.max() / 0.5, np.linalg.norm(motions[len(landmarks) :], axis=1).max() / (0.3 * radius))
    to = pins + motions / scale
    to[: len(landmarks)] = landmarks
    return to


def loop(v, t, target, move, landmarks):
    at, to = v[landmarks], target[landmarks]
    size, goal = diagonal(v), Surface(target, t)
    v = move(v, at, to, 0.5 * size)
    area = np.linalg.norm(np.cross(v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]]), axis=1).sum() / 2
    edge = np.linalg.norm(v[t] - v[np.roll(t, 1, axis=1)], axis=2).mean()
    finest = max(np.sqrt(area / 1200), 1.5 * edge)
    radius = size
    while SPACING * radius >= finest:
        count = max(4000, int(10 * area / (SPACING * radius) ** 2))
        found = matches(Surface(v, t), goal, count)
        for _ in range(ROUNDS):
            places = Surface(v, t).samples(count)[0]
            free = farthest_points(places, len(places), v[landmarks], SPACING * radius)
            if not free:
                break
            pins = np.concatenate([v[landmarks], places[free]])
            moved = move(v, pins, pin_motions(pins, to, *found[1:], radius), radius)
            now = matches(Surface(moved, t), goal, count)
            if now[0] > found[0]:
                break
            is_worthwhile = now[0] < WORTHWHILE * found[0]
            v, found = moved, now
            if not is_worthwhile:
                break
        radius *= FINER
    return v


def by_knead(command, folder, with_surface):
    session, result = folder / "fit.knead", folder / "fitted.ply"
    words = [command, "fit", folder / "source.ply", folder / "target.ply", "--landmarks", folder / "pairs.csv"]
    words += ["--surface"] if with_surface else []
    done = subprocess.run([*words, "--json", "-o", session], capture_output=True, text=True)
    if done.returncode not in (0, 4):
        raise RuntimeError(done.stderr)
    subprocess.run([command, "deform", folder / "source.ply", session, "-q", "-o", result], check=True)
    remeshed = json.loads(done.stdout)["remeshed_strokes"]
    return knead.read(result), f"{remeshed} remeshed" if remeshed else ""


def compare(shape, name, percent, seed, options):
    v, t = shape.vertices.copy(), shape.triangles.astype(np.int64)
    target, size = hide(v, seed, percent), diagonal(v)
    landmarks = farthest_points(v, options.landmarks)
    moved = np.linalg.norm(target - v, axis=1) / size
    before = distances(v, t, target, t).mean() / size
    print(f"\n{name}, {len(v)} vertices, seed {seed}: points move by {100 * moved.max():.1f}% at most,")
    print(f"{100 * moved.mean():.1f}% in the mean; mean distance before {100 * before:.3f}%")
    print(f"{'':16} {'mean %':>8} {'95% %':>8} {'max %':>8} {'volume':>9} {'crossings':>9} {'s':>7}")
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        shape.write(folder / "source.ply", double=True)
        shape.vertices = target
        shape.write(folder / "target.ply", double=True)
        shape.vertices = v
        pairs = "".join(f"{i},{i}\n" for i in landmarks)
        (folder / "pairs.csv").write_text("source_vertex,target_vertex\n" + pairs)
        ways = {"knead": None, "gauss": flow, "spline": spline}
        for with_surface in (False, True):
            for way, move in ways.items():
                if move and with_surface and len(v) > options.loops_up_to:
                    continue
                start, note = time.perf_counter(), ""
                if move is None:
                    result, note = by_knead(options.knead, folder, with_surface)
                    x, faces = result.vertices, result.triangles.astype(np.int64)
                elif with_surface:
                    x, faces = loop(v, t, target, move, landmarks), t
                else:
                    x, faces = move(v, v[landmarks], target[landmarks], 0.5 * size), t
                seconds = time.perf_counter() - start
                there = distances(x, faces, target, t) / size
                crossings = knead.check(x, faces.astype(np.uint32))["self_intersections"]
                print(
                    f"{way + (' surface' if with_surface else ''):16} {100 * there.mean():8.4f} "
                    f"{100 * np.quantile(there, 0.95):8.3f} {100 * there.max():8.2f} "
                    f"{volume(x, faces) / volume(v, t) - 1:9.1e} {crossings:9} {seconds:7.1f} {note}",
                    flush=True,
                )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("shapes", nargs="*", metavar="SHAPE")
    parser.add_argument("--knead", default="build/release/knead")
    parser.add_argument("--seeds", type=int, nargs="+", default=[1])
    parser.add_argument("--moves", type=float, nargs="+", default=[6, 20])
    parser.add_argument("--landmarks", type=int, default=20)
    parser.add_argument("--loops-up-to", type=int, default=12000)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        if not options.shapes:
            options.shapes = [f"{place}/hand.ply"]
            subprocess.run([options.knead, "make", "hand", "-n", "8000", "-q", "-o", options.shapes[0]], check=True)
        for path in options.shapes:
            for percent in options.moves:
                for seed in options.seeds:
                    compare(knead.read(path), Path(path).stem, percent, seed, options)


if __name__ == "__main__":
    main()
