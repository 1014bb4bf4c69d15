"""Fits shapes to themselves in other poses and measures where each vertex ends: `knead fit` beside others.

    PYTHONPATH=build/release/python python3 bench/fit_bench.py [FOLDER...] [--knead build/release/knead]
        [--beside OTHER_KNEAD] [--landmarks 0 12 20] [--seconds 600] [--volume keep]
        [--peers cpd nricp spline functional] [--python PYTHON]

Without FOLDER: the procedural figure and hand in known poses (strokes `pose`, `bend` and `pins` of this file). FOLDER holds
shapes of the same mesh, for instance registrations of scans: all pairs of neighbouring names are fitted, and vertex i of
one belongs to vertex i of the next. Landmarks are vertices, each the farthest from those before it. Columns:

- error: mean and greatest distance of vertices from where they belong, times 100 / sqrt(area)
- distance: mean of the surfaces, percent of the diagonal
- crossings: pairs of triangles that cross and did not before; volume: relative change
- stretch: greatest of a triangle (or inverse of the least), that of 99%, rms of its logarithm
- exit: the exit code of `knead fit`; s: processor seconds

--beside: the same command line with another program, such as an older version. --peers: the fits of fit_peers.py, run by
PYTHON, which needs their packages: `python3 -m venv peers && peers/bin/pip install pycpd trimesh rtree scipy pyfmaps`, then
`--python peers/bin/python`. They get --seconds, too. `knead fit` also starts from the functional map, as --map.
"""

import argparse
import json
import resource
import subprocess
import tempfile
from pathlib import Path

import numpy as np

import knead


def diagonal(v):
    return np.linalg.norm(np.ptp(v, axis=0))


def area(v, t):
    return np.linalg.norm(np.cross(v[t[:, 1]] - v[t[:, 0]], v[t[:, 2]] - v[t[:, 0]]), axis=1).sum() / 2


def volume(v, t):
    return np.einsum("ij,ij->", v[t[:, 0]], np.cross(v[t[:, 1]], v[t[:, 2]])) / 6


def farthest_points(points, count):
    chosen = [int(np.linalg.norm(points - points.mean(0), axis=1).argmax())]
    distance = np.full(len(points), np.inf)
    while len(chosen) < count:
        distance = np.minimum(distance, np.linalg.norm(points - points[chosen[-1]], axis=1))
        chosen.append(int(distance.argmax()))
    return chosen[:count]


def stretches(t, rest, now):
    """The singular values of the triangles' maps, (n, 2), the greater first."""
    a, b = rest[t[:, 1]] - rest[t[:, 0]], rest[t[:, 2]] - rest[t[:, 0]]
    c, d = now[t[:, 1]] - now[t[:, 0]], now[t[:, 2]] - now[t[:, 0]]
    def dot(x, y):
        return np.einsum("ij,ij->i", x, y)

    area2 = np.maximum(np.linalg.norm(np.cross(a, b), axis=1) ** 2, 1e-300)
    trace = (dot(b, b) * dot(c, c) - 2 * dot(a, b) * dot(c, d) + dot(a, a) * dot(d, d)) / area2
    product = np.linalg.norm(np.cross(c, d), axis=1) ** 2 / area2
    greater = (trace + np.sqrt(np.maximum(trace**2 - 4 * product, 0))) / 2
    return np.sqrt(np.stack([greater, product / np.maximum(greater, 1e-300)], axis=1))


def new_crossings(faces, before, after):
    old = {tuple(pair) for pair in np.sort(knead.crossings(before, faces), axis=1).tolist()}
    return sum(tuple(pair) not in old for pair in np.sort(knead.crossings(after, faces), axis=1).tolist())


def part(v, chosen, axis, center, degrees):
    vertices = [[int(i), int(i)] for i in np.flatnonzero(chosen)]
    if degrees == 0:
        return {"vertices": vertices, "hold": True}
    return {"vertices": vertices, "rotate": axis, "center": center, "angle_deg": degrees}


def figure_poses(v):
    """Names and strokes of poses of `knead make figure`."""
    x, y, _ = v.T
    trunk = part(v, (abs(x) < 0.12) & (y > 0.05) & (y < 0.6), None, None, 0)

    def arm(side, axis, degrees):
        return part(v, (side * x > 0.4) & (y > -0.3), axis, [0.21 * side, 0.475, 0], degrees)

    def leg(side, degrees):
        return part(v, (side * x > 0) & (y < -0.3), [1, 0, 0], [0.105 * side, -0.06, 0], degrees)

    sideways, forward = [0, 0, 1], [1, 0, 0]
    return {
        "down": [trunk, arm(1, sideways, -30), arm(-1, sideways, 25)],
        "up": [trunk, arm(1, sideways, 75), arm(-1, sideways, -40), part(v, y > 0.72, [0, 1, 0], [0, 0.6, 0], 25)],
        "walk": [trunk, arm(1, forward, 50), arm(-1, forward, -50), leg(1, -35), leg(-1, 30)],
    }


def procedural(command, folder):
    """Yields a name, vertices, vertices of the target, and triangles."""
    for kind in ("figure", "hand"):
        path = folder / f"{kind}.ply"
        subprocess.run([command, "make", kind, "-n", "5000", "-q", "-o", path], check=True)
        shape = knead.read(path)
        v, t = shape.vertices.copy(), shape.triangles
        if kind == "figure":
            for name, parts in figure_poses(v).items():
                yield f"figure, {name}", v, knead.deform(v, knead.stroke({"tool": "pose", "parts": parts}), t), t
            continue
        bend = knead.Bend(center=[0, 0, 0], axis=[1, 0, 0], normal=[0, -1, 0], width=0.8, angle_deg=24)
        twist = knead.Twist(center=[0, 0, 0], axis=[0, 1, 0], rate_deg=40, inner=-0.5, outer=0.5)
        pull = knead.Implicit(path=[[0.1, 0.9, 0], [0.25, 0.95, 0.2]], inner=0.1, outer=0.7)
        yield "hand, bent and pulled", v, knead.deform(v, [bend, twist, pull]), t


def pairs_of(folder):
    paths = sorted(p for p in folder.iterdir() if p.suffix in (".ply", ".off", ".obj"))
    for a, b in zip(paths, paths[1:]):
        source, target = knead.read(a), knead.read(b)
        yield f"{a.stem} to {b.stem}", source.vertices, target.vertices, source.triangles


def run_fit(command, folder, options):
    seconds = options.seconds
    session, result = folder / "fit.knead", folder / "fitted.ply"
    words = [command, "fit", folder / "source.ply", folder / "target.ply", "--surface", "-o", session, "-q"]
    if (folder / "pairs.csv").exists():
        words += ["--landmarks", folder / "pairs.csv"]
    if (folder / "map.csv").exists():
        words += ["--map", folder / "map.csv"]
    if options.volume != "keep":
        words += ["--volume", options.volume]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        done = subprocess.run(words, capture_output=True, text=True, timeout=seconds)
    except subprocess.TimeoutExpired:
        return None, f"over {seconds} s", seconds
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    if done.returncode not in (0, 4):
        return None, done.stderr.strip(), used
    deform = [command, "deform", folder / "source.ply", session, "-q", "--precision", "double", "-o", result]
    if subprocess.run(deform, capture_output=True).returncode != 0:
        return None, f"exit {done.returncode}, and the session cannot be applied", used
    return knead.read(result), done.returncode, used


def run_peer(name, v, target, t, chosen, options, folder):
    """Returns vertices or a reason, and processor seconds."""
    shapes, result = folder / "shapes.npz", folder / f"{name}.npy"
    np.savez(shapes, source=v, target=target, faces=t, chosen=np.array(chosen, int))
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    try:
        words = [options.python, Path(__file__).parent / "fit_peers.py", name, shapes, result]
        done = subprocess.run(words, capture_output=True, text=True, timeout=options.seconds)
    except subprocess.TimeoutExpired:
        return f"over {options.seconds:g} s", options.seconds
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime
    if done.returncode != 0:
        return (done.stderr.strip().splitlines() or ["failed"])[-1], used
    return np.load(result), used


def line(name, v, target, t, now, code, seconds):
    error = 100 / np.sqrt(area(target, t)) * np.linalg.norm(now - target, axis=1)
    s = stretches(t, v, now)
    worst = np.maximum(s[:, 0], 1 / np.maximum(s[:, 1], 1e-9))
    there = knead.fit((now, t), (target, t), landmarks=None, surface=False, align=False).report["distance_before"]["mean"]
    return (
        f"| {name} | {error.mean():.2f}, {error.max():.1f} | {100 * there:.3f} | {new_crossings(t, v, now)} "
        f"| {volume(now, t) / volume(v, t) - 1:+.1e} | {worst.max():.2f}, {np.quantile(worst, 0.99):.2f}, "
        f"{np.sqrt((np.log(np.maximum(s, 1e-9)) ** 2).mean()):.3f} | {code} | {seconds:.1f} |"
    )


def start_from(there, name, v, target, t, count, options, folder):
    """A fit that starts from the functional map, which took each vertex to one of the target's."""
    rows = np.concatenate([v, there], axis=1)[:: max(1, len(v) // 1500)]
    np.savetxt(folder / "map.csv", rows, delimiter=",", fmt="%.9g")
    result, code, seconds = run_fit(options.knead, folder, options)
    if result is not None:
        print(line(f"{name}, {count} landmarks | knead, functional map", v, target, t, result.vertices, code, seconds), flush=True)


def compare(name, v, target, t, count, options):
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        knead.write(folder / "source.ply", v, t)
        knead.write(folder / "target.ply", target, t[::-1])  # with equal faces the vertices would be pairs
        chosen = farthest_points(v, count) if count else []
        if count:
            text = "source_vertex,target_vertex\n" + "".join(f"{i},{i}\n" for i in chosen)
            (folder / "pairs.csv").write_text(text)
        for command in filter(None, (options.knead, options.beside)):
            which = "knead" if command == options.knead else "beside"
            result, code, seconds = run_fit(command, folder, options)
            title = f"{name}, {count} landmarks | {which}"
            if result is None or len(result.vertices) != len(v):
                why = code if result is None else "another mesh: remeshed"
                print(f"| {title} | {why} | | | | | | {seconds:.1f} |", flush=True)
            else:
                print(line(title, v, target, t, result.vertices, code, seconds), flush=True)
        for peer in options.peers:
            if peer == "spline" and count < 4:
                continue
            now, seconds = run_peer(peer, v, target, t, chosen, options, folder)
            title = f"{name}, {count} landmarks | {peer}"
            if isinstance(now, str):
                print(f"| {title} | {now} | | | | | | {seconds:.1f} |", flush=True)
                continue
            print(line(title, v, target, t, now, "", seconds), flush=True)
            if peer == "functional":
                start_from(now, name, v, target, t, count, options, folder)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folders", nargs="*", metavar="FOLDER", type=Path)
    parser.add_argument("--knead", default="build/release/knead")
    parser.add_argument("--beside")
    parser.add_argument("--landmarks", type=int, nargs="+", default=[0, 12, 20])
    parser.add_argument("--seconds", type=float, default=600)
    parser.add_argument("--volume", default="keep", choices=["keep", "free"])
    parser.add_argument("--peers", nargs="*", default=[], choices=["cpd", "nricp", "spline", "functional"])
    parser.add_argument("--python", default="python3")
    options = parser.parse_args()
    print("| pair | | error | distance % | new crossings | volume | stretch | exit | s |")
    print("| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: |")
    with tempfile.TemporaryDirectory() as place:
        sources = [pairs_of(folder) for folder in options.folders] or [procedural(options.knead, Path(place))]
        for source in sources:
            for name, v, target, t in source:
                for count in options.landmarks:
                    compare(name, v, target, t, count, options)


if __name__ == "__main__":
    main()
