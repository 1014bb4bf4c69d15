#!/usr/bin/env python3
"""What `knead deform` leaves alone in real files, and whether what it changes is right. Run by hand; not part of ctest.

    /usr/bin/python3 tests/surveys/check_files.py build/release/knead ../shared/meshes/originals

Needs numpy. Files are read by mesh_files.py, which shares no code with Knead. Each OBJ, PLY, OFF, STL, GLB and XYZ file
below the folder is deformed by a pull, a twist, a bend and a turn of the whole, in its own format. Then:

bytes      all but the coordinates and normals, and the components of those that kept their value, have their bytes; GLB:
           the JSON too but min and max of positions, which are exactly those of the numbers stored
numbers    in text, the shortest decimals that read back as the same number
positions  those of the same points as doubles, through a PLY written by this program, to the rounding of the format
normals    keep their length; under a turn they turn with it; else they are compared with the flow's own Jacobian, by
           central differences of points deformed in double precision (of points without faces: within 1e-3 rad)
again      a session without strokes gives the same bytes

Option: --keep DIR leaves what was written. Exit code 0: every check passed.
"""
import argparse
import glob
import json
import os
import subprocess
import sys
import tempfile

import numpy as np

import mesh_files

TURN_DEG = 50.0
TURN_AXIS = np.array([1.0, 2.0, 3.0]) / np.sqrt(14)


def sessions(box_min, box_max):
    c = (box_min + box_max) / 2
    d = float(np.linalg.norm(box_max - box_min))
    a = c.tolist()
    tip = (c + 0.4 * (box_max - c)).tolist()
    end = (np.array(tip) + d * np.array([0.1, 0.15, -0.05])).tolist()
    yield "pull", {"tool": "implicit", "path": [tip, end], "inner": 0.1 * d, "outer": 0.3 * d}
    yield "twist", {"tool": "twist", "center": a, "axis": [1, 0.2, 0], "rate_deg": 150 / d, "inner": 0.0,
                    "outer": 0.2 * d}
    yield "bend", {"tool": "bend", "center": a, "axis": [0, 0, 1], "normal": [0.3, 1, 0], "width": 0.3 * d,
                   "angle_deg": 50}
    yield "turn", {"tool": "rotate", "center": a, "axis": TURN_AXIS.tolist(), "angle_deg": TURN_DEG, "inner": 2 * d,
                   "outer": 3 * d}


class Checker:
    def __init__(self, knead, folder):
        self.knead, self.folder, self.failed = knead, folder, 0

    def expect(self, holds, what):
        if not holds:
            self.failed += 1
            print("    FAILED:", what)

    def deform(self, shape, session, out, *options):
        r = subprocess.run([self.knead, "deform", shape, session, "-q", "-o", out, *options], capture_output=True,
                           text=True)
        self.expect(r.returncode == 0, f"{shape} {session}: exit code {r.returncode} {r.stderr}")
        return r.returncode == 0

    def path(self, name):
        return os.path.join(self.folder, name)

    def session(self, *strokes):
        path = self.path("session.knead")
        with open(path, "w") as file:
            file.write('{"knead": 1}\n' + "".join(json.dumps(s) + "\n" for s in strokes))
        return path

    def flow(self, points, session):
        """Where points go, in double precision."""
        mesh_files.write_points(self.path("points.ply"), points)
        if not self.deform(self.path("points.ply"), session, self.path("moved.ply"), "--precision", "double",
                           "--tolerance", "1e-10"):
            return points
        return mesh_files.read(self.path("moved.ply")).values["position"]

    def check_bytes(self, before, after):
        self.expect(before.skeleton() == after.skeleton(), "bytes other than coordinates and normals changed")
        for name in before.values:
            same = before.values[name] == after.values[name]
            was, now = before.spans[name].reshape(-1, 2), after.spans[name].reshape(-1, 2)
            for i, kept in enumerate(same.ravel()):
                old, new = before.data[slice(*was[i])], after.data[slice(*now[i])]
                if kept and old != new and not is_zero(before, old):
                    self.expect(False, f"{name} {i // 3}: {old!r} became {new!r}, the same number")
                    break
                if not kept and after.text and not is_shortest(new, after.single[name]):
                    self.expect(False, f"{name} {i // 3}: {new!r} is not the shortest")
                    break

    def check_json(self, before, after):
        old, _ = mesh_files.glb_json(before.data)
        new, _ = mesh_files.glb_json(after.data)
        for mesh in new["meshes"]:
            for primitive in mesh["primitives"]:
                a = new["accessors"][primitive["attributes"]["POSITION"]]
                view = new["bufferViews"][a["bufferView"]]
                start = mesh_files.glb_json(after.data)[1] + 8 + view.get("byteOffset", 0) + a.get("byteOffset", 0)
                stride = view.get("byteStride", 12)
                rows = [np.frombuffer(after.data, "<f4", 3, start + stride * i) for i in range(a["count"])]
                for bound, of in (("min", np.min), ("max", np.max)):
                    self.expect(a[bound] == of(rows, axis=0).astype(float).tolist(), f"{bound}: {a[bound]}")
        for document in (old, new):
            for a in document["accessors"]:
                if a["type"] == "VEC3":
                    a.pop("min", None), a.pop("max", None)
        self.expect(old == new, "the JSON changed in more than min and max")

    def check_positions(self, before, after, session):
        points = before.positions()
        expected = self.flow(points, session)
        d = np.linalg.norm(points.max(0) - points.min(0))
        worst = np.abs(after.positions() - expected).max() / d
        rounding = 2e-7 * np.abs(points).max() / d
        self.expect(worst < 1.5e-5 + rounding, f"positions differ by {worst:.1e} of the diagonal")
        moved = np.any(after.positions() != points, axis=1)
        self.expect(moved.any(), "nothing moved")
        return worst, moved

    def check_normals(self, before, after, session, is_turn):
        old, new = before.normals(), after.normals()
        length = np.linalg.norm(old, axis=1)
        off = np.abs(np.linalg.norm(new, axis=1) - length).max()
        is_stl = not before.normal_of
        self.expect(off < 2e-6 or is_stl, f"lengths of normals changed by {off:.1e}")
        if is_turn:
            real = facet_errors(before, old) < 1e-4 if is_stl else length > 0
            error = np.abs(new - turned(old))[real].max()
            self.expect(error < 2e-4, f"normals differ from the turned ones by {error:.1e}")
            return f"turned to {error:.0e}"
        if is_stl:
            changed = np.any(before.values["position"] != after.values["position"], axis=1).reshape(-1, 3).any(axis=1)
            error = np.nanmax(facet_errors(after, new)[changed & (length > 0.5)])
            self.expect(error < 1e-3, f"facet normals are off by {error:.1e}")
            self.expect(not np.isnan(new).any(), "a normal is NaN")
            return f"facets to {error:.0e}"
        pairs = np.unique(np.array(before.normal_of), axis=0)
        pairs = pairs[length[pairs[:, 1]] > 0]
        expected, ok = self.jacobian_normals(before.positions()[pairs[:, 0]], old[pairs[:, 1]], session)
        n = new[pairs[:, 1]] / length[pairs[:, 1], None]
        angle = np.degrees(np.arccos(np.clip(np.sum(n * expected, axis=1), -1, 1)))[ok]
        if before.points:
            self.expect(np.radians(angle).max() < 1e-3, f"normals of points are off by {angle.max():.3f} degrees")
        self.expect(np.median(angle) < 5 or len(old) < 500, f"normals are off by {np.median(angle):.1f} degrees at the median")
        return f"angle to the flow's: median {np.median(angle):.2f}, 95% {np.percentile(angle, 95):.1f}, " \
               f"most {angle.max():.1f} degrees"

    def jacobian_normals(self, p, n, session):
        n = n / np.linalg.norm(n, axis=1, keepdims=True)
        helper = np.where(np.abs(n[:, :1]) < 0.9, [[1.0, 0, 0]], [[0, 1.0, 0]])
        u = np.cross(n, helper)
        u /= np.linalg.norm(u, axis=1, keepdims=True)
        v = np.cross(n, u)
        h = 1e-5 * np.linalg.norm(p.max(0) - p.min(0))
        moved = self.flow(np.concatenate([p + h * u, p - h * u, p + h * v, p - h * v]), session)
        a, b, c, d = np.split(moved, 4)
        result = np.cross(a - b, c - d)
        size = np.linalg.norm(result, axis=1)
        return result / size[:, None], size > 0

    def run(self, path):
        print(path)
        kind = path.rsplit(".", 1)[1].lower()
        before = mesh_files.read(path)
        points = before.positions()
        out = self.path("out." + kind)
        if self.deform(path, self.session(), out):
            self.expect(open(out, "rb").read() == before.data, "without strokes the bytes differ")
        for name, stroke in sessions(points.min(0), points.max(0)):
            session = self.session(stroke)
            if not self.deform(path, session, out):
                continue
            after = mesh_files.read(out)
            if after.values["position"].shape != before.values["position"].shape:
                self.expect(False, "another number of vertices")
                continue
            self.check_bytes(before, after)
            if kind == "glb":
                self.check_json(before, after)
            worst, moved = self.check_positions(before, after, session)
            line = f"  {name:5s} {moved.sum()} of {len(moved)} moved, positions to {worst:.0e}"
            if before.normals() is not None:
                line += "; normals " + self.check_normals(before, after, session, name == "turn")
            print(line)


def is_zero(file, old):
    """Whether these are the bytes of a zero, which may change its sign."""
    return not file.text and not any(old.replace(b"\x80", b"\0"))


def facet_errors(file, normals):
    """How far the normals are from those of the facets, on either side; NaN where a facet is too thin to say."""
    p = file.values["position"].reshape(-1, 3, 3)
    n = np.cross(p[:, 1] - p[:, 0], p[:, 2] - p[:, 0])
    area = np.linalg.norm(n, axis=1)
    longest = np.max([np.sum((p[:, i] - p[:, i - 1]) ** 2, axis=1) for i in range(3)], axis=0)
    clear = area > 1e-2 * longest
    n /= np.where(clear, area, 1)[:, None]
    n *= np.where(np.sum(n * normals, axis=1, keepdims=True) < 0, -1, 1)
    return np.where(clear, np.abs(normals - n).max(axis=1), np.nan)


def is_shortest(word, single):
    text = word.decode()
    value = float(text)
    other = str(np.float32(value)) if single else repr(value)
    digits = lambda t: t.lower().split("e")[0].replace(".", "").replace("-", "").strip("0")
    exact = float(np.float32(value)) == float(np.float32(float(other))) if single else value == float(other)
    return exact and len(digits(text)) <= len(digits(other))


def turned(vectors):
    a = np.radians(TURN_DEG)
    along = np.outer(vectors @ TURN_AXIS, TURN_AXIS)
    return along + (vectors - along) * np.cos(a) + np.cross(TURN_AXIS, vectors) * np.sin(a)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("knead")
    parser.add_argument("paths", nargs="+", help="files, or folders of them")
    parser.add_argument("--keep")
    options = parser.parse_args()
    files = []
    for path in options.paths:
        found = sorted(glob.glob(os.path.join(path, "**"), recursive=True)) if os.path.isdir(path) else [path]
        files += [f for f in found if f.lower().endswith((".obj", ".ply", ".off", ".stl", ".glb", ".xyz"))]
    with tempfile.TemporaryDirectory() as folder:
        checker = Checker(os.path.abspath(options.knead), options.keep or folder)
        for file in files:
            checker.run(file)
    print(f"{len(files)} files, {checker.failed} checks failed")
    return 1 if checker.failed or not files else 0


if __name__ == "__main__":
    sys.exit(main())
