#!/usr/bin/env python3
"""Agreement of `knead deform` with an independent integration. Run by hand; not part of ctest.

    /usr/bin/python3 tests/surveys/check_agreement.py build/release/knead ../shared/meshes

Needs numpy and scipy. Nothing here shares code with Knead: the fields are written down from the method,
meshes are read by the few lines below, and path lines are integrated by scipy's DOP853 at 1e-13. Each case
runs on a whole mesh; the vertices integrated here are a random sample of the moved ones and those where
Knead's own settings differ most from one another, so that the worst vertex of the mesh is among them.

Options: --samples N (60; all meshes then take about an hour on two free cores), --mesh NAME and --case NAME (only those), --jobs N (2), --seed N, --keep DIR.
Exit code 0: every check passed.
"""
import argparse
import json
import multiprocessing
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time

import numpy as np

from agreement_cases import cases
from agreement_flows import agreement, flow_of, surely_outside, worst

MESHES = ["bunny_35k", "armadillo_43k", "hand_50k", "fandisk_6k", "dragon_50k", "camel_35k"]

DEFAULT_BAR = 2e-5  # of the box diagonal
DOUBLE_BAR = 1e-8


# Meshes -----------------------------------------------------------------------------------------------

def read_ply(path):
    """Binary little-endian PLY: positions in the file's own type, faces as an array of triangles."""
    with open(path, "rb") as file:
        data = file.read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    kinds = {"float": "<f4", "float32": "<f4", "double": "<f8", "float64": "<f8",
             "uchar": "u1", "uint8": "u1", "int": "<i4", "int32": "<i4", "uint": "<u4"}
    count, faces, fields, element = 0, 0, [], ""
    lists = []
    for line in data[:end].decode("latin-1").split("\n"):
        words = line.split()
        if words[:1] == ["format"]:
            assert words[1] == "binary_little_endian", words
        if words[:1] == ["element"]:
            element = words[1]
            if element == "vertex":
                count = int(words[2])
            if element == "face":
                faces = int(words[2])
        if words[:1] == ["property"]:
            if element == "vertex":
                fields.append((words[2], kinds[words[1]]))
            elif element == "face":
                lists.append((kinds[words[2]], kinds[words[3]]))
    vertices = np.frombuffer(data, np.dtype(fields), count, end)
    points = np.stack([vertices[k] for k in "xyz"], 1)
    triangles = np.zeros((0, 3), int)
    if faces:
        rows = np.frombuffer(data, np.dtype([("n", lists[0][0]), ("i", lists[0][1], 3)]), faces,
                             end + vertices.nbytes)
        assert (rows["n"] == 3).all()
        triangles = rows["i"].astype(int)
    return points, triangles


def write_ply(path, points, triangles):
    header = ("ply\nformat binary_little_endian 1.0\nelement vertex %d\nproperty float x\nproperty float y\n"
              "property float z\nelement face %d\nproperty list uchar int vertex_indices\nend_header\n")
    rows = np.zeros(len(triangles), [("n", "u1"), ("i", "<i4", 3)])
    rows["n"], rows["i"] = 3, triangles
    with open(path, "wb") as file:
        file.write((header % (len(points), len(triangles))).encode())
        file.write(points.astype("<f4").tobytes() + rows.tobytes())


def write_session(path, events):
    def plain(value):
        if isinstance(value, np.ndarray):
            return [float(v) for v in value]
        if isinstance(value, (list, tuple)):
            return [plain(v) for v in value]
        if isinstance(value, dict):
            return {k: plain(v) for k, v in value.items()}
        if isinstance(value, np.floating):
            return float(value)
        return value
    with open(path, "w") as file:
        for event in [{"knead": 1}] + events:
            file.write(json.dumps(plain(event)) + "\n")
    return [plain(e) for e in events]


# Checks -----------------------------------------------------------------------------------------------

class Run:
    def __init__(self, knead, folder):
        self.knead, self.folder = knead, folder

    def path(self, name):
        return os.path.join(self.folder, name)

    def __call__(self, shape, session, out, *options, expect=0):
        done = subprocess.run([self.knead, "deform", shape, session, "-q", "-o", self.path(out), *options],
                              capture_output=True, text=True)
        if done.returncode != expect:
            raise AssertionError("exit %d, expected %d: %s" % (done.returncode, expect, done.stderr.strip()))
        return done.stderr if expect else read_ply(self.path(out))[0]


def check(task):
    mesh, name, events, options = task
    began = time.time()
    rng = np.random.default_rng(options["seed"])
    folder = tempfile.mkdtemp(prefix="knead-agreement-", dir=options["keep"])
    run = Run(options["knead"], folder)
    shape = os.path.join(options["meshes"], mesh + ".ply")
    points, triangles = read_ply(shape)
    diagonal = float(np.sqrt(((points.max(0).astype(float) - points.min(0)) ** 2).sum()))
    session = run.path("s.knead")
    events = write_session(session, events)
    faults, notes = [], {}

    def hold(what, value, bar):
        notes[what] = value
        if not value <= bar:
            faults.append("%s %.3g > %.3g" % (what, value, bar))

    def same(what, a, b):
        if a.tobytes() != b.tobytes():
            faults.append("%s: %d vertices differ" % (what, (a != b).any(1).sum()))

    try:
        if name.endswith("-refused"):
            message = run(shape, session, "refused.ply", expect=3)
            if message.count("\n") != 1 or os.path.exists(run.path("refused.ply")):
                faults.append("refusal is not one line, or left a file: " + message)
            numbers = re.findall(r"radius[^0-9]*([0-9][0-9.e+-]*[0-9])", message)
            notes["refused"] = message.strip()
            worked = False
            for text in numbers:
                events[0]["radius"] = float(text)
                write_session(session, events)
                try:
                    run(shape, session, "suggested.ply")
                    worked = True
                except AssertionError:
                    pass
            if not worked:
                faults.append("no suggested radius works: " + message)
            return mesh, name, faults, notes, time.time() - began

        flow = flow_of(events)
        plain = run(shape, session, "default.ply", "--threads", "1")
        exact = run(shape, session, "double.ply", "--threads", "1", "--precision", "double", "--tolerance", "1e-10")
        other = run(shape, session, "other.ply", "--precision", "double", "--tolerance", "1e-10",
                    "--integrator", "tsit5")
        assert exact.dtype == np.dtype("<f8") and plain.dtype == np.dtype("<f4")
        gap_plain, gap_exact = worst(plain, exact, diagonal), worst(exact, other, diagonal)
        moved = np.flatnonzero((exact != points).any(1))
        notes["moved"] = len(moved)
        if len(moved) < 50:
            faults.append("only %d vertices move: the case is too weak" % len(moved))
        third = options["samples"] // 3
        sample = np.unique(np.concatenate([
            np.argsort(-gap_plain)[:third], np.argsort(-gap_exact)[:third],
            rng.choice(moved, min(len(moved), options["samples"] - 2 * third), replace=False)]))
        error, truth = agreement(flow, points[sample], exact[sample], diagonal, DOUBLE_BAR)
        hold("double", error, DOUBLE_BAR)
        hold("default", worst(plain[sample], truth, diagonal).max(), DEFAULT_BAR)
        hold("default-all", gap_plain.max(), DEFAULT_BAR)
        hold("double-all", gap_exact.max(), DOUBLE_BAR)

        outside = surely_outside(flow, points.astype(float))
        notes["outside"] = int(outside.sum())
        same("outside, default", plain[outside], points[outside])
        same("outside, double", exact[outside], points[outside].astype("<f8"))

        back = run(run.path("default.ply"), session, "back.ply", "--inverse")
        hold("inverse", worst(back, points, diagonal).max(), DEFAULT_BAR)
        back = run(run.path("double.ply"), session, "back.ply", "--inverse", "--precision", "double",
                   "--tolerance", "1e-10")
        hold("inverse double", worst(back, points, diagonal).max(), DOUBLE_BAR)

        with open(run.path("default.ply"), "rb") as file:
            first = file.read()
        for threads in ("2", "1"):
            run(shape, session, "again.ply", "--threads", threads)
            with open(run.path("again.ply"), "rb") as file:
                if file.read() != first:
                    faults.append("another file with --threads " + threads)
        order = rng.permutation(len(points))
        place = np.empty_like(order)
        place[order] = np.arange(len(order))
        write_ply(run.path("permuted.ply"), points[order], place[triangles][rng.permutation(len(triangles))])
        same("permuted", run(run.path("permuted.ply"), session, "p.ply", "--threads", "2"), plain[order])
        same("permuted, double", run(run.path("permuted.ply"), session, "p.ply", "--threads", "2", "--precision",
                                     "double", "--tolerance", "1e-10"), exact[order])

        strokes = len([e for e in events if "tool" in e]) if name != "session" else 3
        until = 0.5 + (strokes - 1)
        part = run(shape, session, "until.ply", "--until", repr(until), "--precision", "double", "--tolerance", "1e-10")
        few = sample[:: max(1, len(sample) // 30)]
        hold("until", agreement(flow_of(events, until), points[few], part[few], diagonal, DOUBLE_BAR)[0], DOUBLE_BAR)

        if name in ("session", "implicit-swept"):
            subprocess.run([run.knead, "deform", shape, session, "-q", "--frames", "5", "-o", run.path("F_%04d.ply")],
                           check=True)
            frames = sorted(f for f in os.listdir(folder) if f.startswith("F_"))
            if len(frames) != 5:
                faults.append("frames: " + " ".join(frames))
            else:
                same("first frame", read_ply(run.path(frames[0]))[0], points)
                same("last frame", read_ply(run.path(frames[4]))[0], plain)
                half = run(shape, session, "half.ply", "--until", repr(strokes / 2))
                hold("middle frame", worst(read_ply(run.path(frames[2]))[0], half, diagonal).max(), DEFAULT_BAR)
    except AssertionError as error:
        faults.append(str(error))
    except Exception as error:  # a broken output is a fault of the case, not the end of the run
        faults.append(repr(error))
    finally:
        if not options["keep"]:
            shutil.rmtree(folder)
    return mesh, name, faults, notes, time.time() - began


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("knead")
    parser.add_argument("meshes")
    parser.add_argument("--samples", type=int, default=60)
    parser.add_argument("--mesh", action="append")
    parser.add_argument("--case", action="append")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--keep", help="keep the sessions and outputs in this folder")
    given = parser.parse_args()
    if given.keep:
        os.makedirs(given.keep, exist_ok=True)
    options = {"knead": os.path.abspath(given.knead), "meshes": given.meshes, "samples": given.samples,
               "seed": given.seed, "keep": given.keep}
    tasks = []
    for mesh in given.mesh or MESHES:
        points, triangles = read_ply(os.path.join(given.meshes, mesh + ".ply"))
        points = points.astype(float)
        diagonal = float(np.sqrt(((points.max(0) - points.min(0)) ** 2).sum()))
        rng = np.random.default_rng([given.seed, len(points)])
        for name, events in cases(points, triangles, diagonal, rng).items():
            if not given.case or name in given.case:
                tasks.append((mesh, name, events, options))
    if given.case is None:
        for tool in ("bend", "twist"):
            if not any(name == "cylinder-%s-refused" % tool for _, name, _, _ in tasks):
                print("no part for a limit cylinder was found for", tool)
    bad = 0
    with multiprocessing.Pool(given.jobs) as pool:
        for mesh, name, faults, notes, seconds in pool.imap_unordered(check, tasks):
            bad += bool(faults)
            text = "  ".join("%s %.2g" % (k, v) if isinstance(v, float) else "%s %s" % (k, v)
                             for k, v in notes.items())
            print("%-4s %s %s (%.0f s)  %s" % ("BAD" if faults else "ok", mesh, name, seconds, text), flush=True)
            for fault in faults:
                print("     " + fault, flush=True)
    print("%d cases, %d bad" % (len(tasks), bad))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
