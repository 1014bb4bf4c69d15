#!/usr/bin/env python3
"""What a person waits for, as a table with aims. Every row runs the command, as a person does.

    bench/waits.py [--build build/release] [--meshes FOLDER] [--backend cpu|gpu] [--runs 3] [--processor] [ROW...]

Without the folder's scans the shapes are procedural, of the same size. ROW is a part of a row's name. Times are medians
on the clock; of pictures, Studio's too, strong sessions and paint, processor time. With --processor all are processor time, which
depends less on what else the machine does.
"""

import argparse
import json
import math
import os
import pathlib
import random
import re
import resource
import statistics
import subprocess
import tempfile
import time


class Bench:
    def __init__(self, options, folder):
        self.build = pathlib.Path(options.build).resolve()
        self.meshes = pathlib.Path(options.meshes)
        self.backend = options.backend
        self.runs = options.runs
        self.processor = options.processor
        self.folder = folder

    def run(self, *arguments, program="knead"):
        """Returns the seconds on the clock and of the processor."""
        began, used = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
        result = subprocess.run([self.build / program, *map(str, arguments)], capture_output=True, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if result.returncode not in (0, 4):  # 4: the result is written, and less good than asked
            raise SystemExit(f"waits: {' '.join(map(str, arguments))}: {result.stderr.strip()}")
        processor = after.ru_utime + after.ru_stime - used.ru_utime - used.ru_stime
        return time.monotonic() - began, processor, result.stdout

    def seconds(self, *arguments, processor=False):
        kind = 1 if processor or self.processor else 0
        return statistics.median(self.run(*arguments)[kind] for _ in range(self.runs))

    def shape(self, file, vertices, kind="knot"):
        """Returns the scan, or a procedural shape of as many vertices."""
        if (self.meshes / file).exists():
            return self.meshes / file
        path = self.folder / f"{kind}_{vertices}.ply"
        if not path.exists():
            self.run("make", kind, "-n", vertices, "-o", path, "-q")
        return path

    def dragon(self):
        return self.shape("dragon_438k_constructed.ply", 437_645)

    def box(self, shape):
        """Returns the shape's middle and its box's diagonal."""
        facts = json.loads(self.run("info", shape, "--json")[2])
        return [(a + b) / 2 for a, b in zip(facts["box_min"], facts["box_max"])], facts["diagonal"]

    def session(self, name, strokes):
        path = self.folder / f"{name}.knead"
        path.write_text("\n".join(map(json.dumps, [{"knead": 1}, *strokes])) + "\n")
        return path

    def deform(self, shape, session, *options, processor=False):
        output = self.folder / f"out{pathlib.Path(shape).suffix}"
        return self.seconds("deform", shape, session, "-o", output, "-q", "--backend", self.backend, *options, processor=processor)

    def brush(self, shape, segments=10):
        middle, size = self.box(shape)
        path = [[middle[0] + 0.1 * size * i / segments, middle[1], middle[2]] for i in range(segments + 1)]
        return {"tool": "implicit", "path": path, "inner": 0.02 * size, "outer": 0.142 * size}


def opened(bench):
    return bench.seconds("info", bench.shape("none", 10_000_000), "-q")


def checked(bench):
    shape = bench.dragon()
    session = bench.session("brush", [bench.brush(shape)])
    return bench.deform(shape, session, "--check") - bench.deform(shape, session)


def remeshed(bench):
    shape = bench.dragon()
    session = bench.session("brush", [bench.brush(shape)])
    return bench.deform(shape, session, "--remesh") - bench.deform(shape, session)


def drawn(bench):
    picture = bench.folder / "picture.png"
    return bench.seconds("render", bench.dragon(), "-o", picture, "--size", "1600x1200", "-q", processor=True)


def started(bench):
    """Studio's first picture, without a window and its panels."""
    script = bench.folder / "first.script"
    picture = {"picture": str(bench.folder / "first.png")}
    lines = [{"size": [1280, 800]}, {"new": "sphere"}, picture]
    script.write_text("\n".join(map(json.dumps, lines)) + "\n")
    times = [bench.run("--script", script, program="knead-studio")[1] for _ in range(bench.runs)]
    return statistics.median(times)


def fitted(bench):
    hand = bench.shape("none", 12_000, "hand")
    posed = bench.folder / "posed.ply"
    bench.run("deform", hand, bench.session("pull", [bench.brush(hand)]), "-o", posed, "-q")
    return bench.seconds("fit", hand, posed, "--surface", "-o", bench.folder / "fit.knead", "-q")


def pinned(bench):
    numbers = random.Random(11)
    points = []
    while len(points) < 300:
        point = [numbers.gauss(0, 1) for _ in range(3)]
        points.append([x / math.hypot(*point) for x in point])
    to = [[x + 0.05 * math.sin(3 * y), y + 0.05 * math.cos(2 * z), z + 0.05 * x * y] for x, y, z in points]
    turns = [{"axis": [numbers.gauss(0, 1) for _ in range(3)], "angle_deg": numbers.uniform(-10, 10)} for _ in points]
    session = bench.session("pins", [{"tool": "pins", "points": points, "to": to, "radius": "auto", "turn": turns}])
    return bench.deform(bench.shape("none", 1000, "sphere"), session)


def painted(bench):
    """What a dab takes after the first, which reads the surface, in segments of a ball of the same reach."""
    sphere = bench.shape("none", 500_000, "sphere")
    nothing = bench.deform(sphere, bench.session("nothing", []), processor=True)
    line = [[math.cos(0.0182 * i), math.sin(0.0182 * i), 0.0005 * i - 0.2] for i in range(800)]  # over two turns
    paint = {"tool": "paint", "path": line, "outer": 0.07, "depth": 0.01}
    ball = {"tool": "implicit", "path": line, "inner": 0.01, "outer": 0.07}
    resolved = bench.folder / "resolved.knead"
    bench.run("resolve", sphere, bench.session("paint", [paint]), "-o", resolved, "-q")
    dabs = sum(len(json.loads(text).get("samples", [0])) for text in resolved.read_text().splitlines()[1:] if text)
    first = bench.deform(sphere, bench.session("first", [{**paint, "path": line[:1]}]), processor=True)
    by_paint = bench.deform(sphere, bench.session("paint", [paint]), processor=True) - first
    drags = 3  # one is over too soon to be measured
    by_ball = bench.deform(sphere, bench.session("ball", drags * [ball]), processor=True) - nothing
    return by_paint / (dabs - 1) / (by_ball / drags / (len(line) - 1))


def strong(bench):
    """Returns the median and the greatest processor time of sessions of five strong strokes."""
    text = bench.run(bench.meshes, 12, 1, 0, program="tests/remesh_survey")[2]
    found = re.search(r"processor seconds \(all\) +median +([0-9.]+) +max +([0-9.]+)", text)
    if not found:
        raise SystemExit(f"waits: no times in what remesh_survey printed:\n{text[-400:]}")
    return tuple(map(float, found.groups()))


ROWS = [
    ("open 10 million vertices", "1.5 s", opened),
    ("check the dragon", "0.5 s", checked),
    ("remesh after a brush", "0.15 s", remeshed),
    ("sessions of strong strokes, remeshed", "4 s, 40 s", strong),
    ("a picture of the dragon, 1600 x 1200", "1 s", drawn),
    ("Studio's first picture", "0.5 s", started),
    ("fit a hand of 12,000 vertices", "10 s", fitted),
    ("300 pins that turn", "0.5 s", pinned),
    ("a further dab, in segments of a ball", "3", painted),
]


def main():
    here = pathlib.Path(__file__).resolve().parent.parent
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--build", default=here / "build/release")
    parser.add_argument("--meshes", default=os.environ.get("KNEAD_MESHES", here / "../shared/meshes"))
    parser.add_argument("--backend", choices=("cpu", "gpu"), default="cpu")
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--processor", action="store_true")
    parser.add_argument("rows", nargs="*")
    options = parser.parse_args()
    load = os.getloadavg()[0]
    print(f"{options.backend}, medians of {options.runs}, {os.cpu_count()} cores, load {load:.1f}")
    print(f"{'what':38} {'aim':>9}  measured")
    with tempfile.TemporaryDirectory() as folder:
        bench = Bench(options, pathlib.Path(folder))
        for name, aim, measure in ROWS:
            if options.rows and not any(row in name for row in options.rows):
                continue
            value = measure(bench)
            values = value if isinstance(value, tuple) else (value,)
            print(f"{name:38} {aim:>9}  {', '.join(f'{x:.2f}' for x in values)}", flush=True)


if __name__ == "__main__":
    main()
