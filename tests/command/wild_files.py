#!/usr/bin/env python3
"""Odd files of every format, made here: read, written unchanged, moved, and read again by other readers.

    python3 tests/command/wild_files.py build/release/knead [--assimp] [--blender] [--keep DIR]

Every file holds the same small shapes, written as real programs write them against the formats' descriptions. A session
moves one corner. Then: `knead info` finds the vertices and faces; a session without strokes gives the same bytes; the
moved file differs only in numbers of vertices that moved; and a reader in this script finds the positions that the
session gives to the plain shape. --assimp also opens the moved files with `assimp info`, where that reads the kind.
--blender has Blender read all files of its kinds before and after; what it finds of those that it reads right must have
moved as well. The files follow from a fixed seed. Exit code 0: no file failed.
"""
import argparse
import itertools
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor

sys.dont_write_bytecode = True  # the sources stay as they are
from wild_formats import read, read_cloud, wild_files  # noqa: E402

PULL = ('{"knead": 1}\n{"tool": "implicit", "inner": 0.2, "outer": 0.75, '
        '"path": [[1, 1, 1], [1.25, 1.5, 1.125]]}\n')


def numbers_removed(data):
    return re.sub(rb"[-+]?\d[\d.]*(e[-+]?\d+)?", b"0", data)


class Check:
    def __init__(self, knead, folder, assimp):
        self.knead, self.folder, self.assimp = os.path.abspath(knead), folder, assimp
        for part in ("in", "same", "moved"):
            os.makedirs(os.path.join(folder, part), exist_ok=True)
        self.write("empty.knead", b'{"knead": 1}\n')
        self.write("pull.knead", PULL.encode())
        corners = [tuple(map(float, p)) for p in itertools.product((0, 1), repeat=3)]
        self.images = {c: c for c in corners}

    def write(self, name, data):
        with open(os.path.join(self.folder, name), "wb") as file:
            file.write(data)

    def read(self, *name):
        with open(os.path.join(self.folder, *name), "rb") as file:
            return file.read()

    def run(self, *words):
        return subprocess.run(words, cwd=self.folder, capture_output=True, text=True, timeout=60, check=False)

    def image_of(self, points):
        """Where the session takes the points, all of which go through a plain text file in doubles."""
        wanted = sorted({p for p in points if p})
        self.write("plain.xyz", "".join("%r %r %r\n" % p for p in wanted).encode())
        done = self.run(self.knead, "deform", "plain.xyz", "pull.knead", "--precision", "double", "--tolerance", "1e-9",
                        "--digits", "shortest", "-q", "-o", "plain_moved.xyz")
        if done.returncode:
            raise SystemExit(done.stderr)
        self.images = dict(zip(wanted, read_cloud(self.read("plain_moved.xyz"))))

    def failure(self, wild):
        """What is wrong with one file; empty: nothing."""
        self.write(os.path.join("in", wild.file), wild.data)
        for name, data in wild.beside.items():
            self.write(os.path.join("in", name), data)
        source = os.path.join("in", wild.file)
        info = self.run(self.knead, "info", source, "--json")
        if wild.refused:
            is_said = info.returncode == 3 and re.search(wild.refused, info.stderr) and info.stderr.count("\n") == 1
            return "" if is_said else f"not refused as it should be: {info.stdout}{info.stderr}"
        if info.returncode:
            return info.stderr
        found = json.loads(info.stdout)
        used = wild.points
        if wild.extension == "stl":
            used = sorted(set(used))
        if (found["vertices"], found["faces"]) != (len([p for p in used if p]), len(wild.faces)):
            return f"{found['vertices']} vertices, {found['faces']} faces"
        return self.unchanged(wild, source) or self.moved(wild, source) or self.opened(wild)

    def deform(self, source, session, target):
        done = self.run(self.knead, "deform", source, session, "--keep-mesh", "-q", "-o", target)
        return done.stderr if done.returncode else ""

    def unchanged(self, wild, source):
        trouble = self.deform(source, "empty.knead", os.path.join("same", wild.file))
        if trouble:
            return trouble
        if self.read("same", wild.file) != wild.data:
            return "other bytes though nothing moved"
        names = [name for name in wild.beside if self.read("same", name) != wild.beside[name]]
        return f"other bytes in {names}" if names else ""

    def moved(self, wild, source):
        trouble = self.deform(source, "pull.knead", os.path.join("moved", wild.file))
        if trouble:
            return trouble
        data = self.read("moved", wild.file)
        where = os.path.join(self.folder, "moved")
        before = read(wild.extension, wild.data, os.path.join(self.folder, "in"))
        after = read(wild.extension, data, where)
        if len(before) != len(wild.points) or len(after) != len(before):
            return f"{len(before)} points were read here, {len(after)} of the moved file"
        for i, (point, old, new) in enumerate(zip(wild.points, before, after)):
            if point is None:
                if str(old) != str(new):
                    return f"vertex {i}, which has no place, was {old} and is {new}"
                continue
            expected = self.images[point]
            if expected == point and new != old:
                return f"vertex {i} does not move, but is {new}"
            if math.dist(expected, new) > wild.tolerance:
                return f"vertex {i} is at {new}, not {expected}"
        if after == before:
            return "nothing moved"
        is_text = wild.extension in ("obj", "off", "ptx") or b"\0" not in data.rstrip(b"\0")
        if is_text and wild.extension not in ("gltf", "glb") and numbers_removed(data) != numbers_removed(wild.data):
            return "not only numbers changed"
        if not is_text and wild.extension not in ("gltf", "glb") and len(data) != len(wild.data):
            return "the length changed"
        return ""

    def opened_by_blender(self, files):
        """The files that Blender reads right before, but not as they should be afterwards. Prints how many it reads."""
        kinds = ("ply", "stl", "obj", "gltf", "glb")
        files = [w for w in files if w.extension in kinds and not w.refused and w.faces]
        paths = [os.path.join(self.folder, part, w.file) for w in files for part in ("in", "moved")]
        self.write("blender.json", json.dumps(paths).encode())
        script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "wild_blender.py")
        done = subprocess.run(["blender", "--background", "--factory-startup", "--python-exit-code", "3", "--python", script,
                               "--", os.path.join(self.folder, "blender.json")],
                              capture_output=True, text=True, timeout=600, check=False)
        line = re.search(r"^PLACES (.*)$", done.stdout, re.MULTILINE)
        if done.returncode or not line:
            raise SystemExit(f"Blender ended early: {done.stdout[-500:]}{done.stderr[-500:]}")
        found = json.loads(line.group(1))

        def is_right(wild, part, image):
            places = found.get(os.path.join(self.folder, part, wild.file), [])
            wanted = sorted({tuple(image(p)) for p in wild.points if p})
            return len(places) == len(wanted) and all(math.dist(a, b) < 1e-3 for a, b in zip(places, wanted))

        read_right = [w for w in files if is_right(w, "in", lambda p: p)]
        print(f"Blender reads {len(read_right)} of {len(files)} files of its kinds")
        return [(w.file, "Blender reads other places") for w in read_right if not is_right(w, "moved", self.images.get)]

    def opened(self, wild):
        if not (self.assimp and wild.assimp):
            return ""
        done = self.run("assimp", "info", os.path.join("moved", wild.file))
        box = re.findall(r"(?:Minimum|Maximum) point\s+\(([^)]*)\)", done.stdout)
        if done.returncode or len(box) != 2:
            return "assimp: " + done.stdout[:300]
        columns = list(zip(*(self.images[p] for p in wild.points if p)))
        for found, wanted in zip(box, ([min(c) for c in columns], [max(c) for c in columns])):
            if math.dist([float(x) for x in found.split()], wanted) > 1e-4:
                return f"assimp finds the box {box}"
        return ""


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", maxsplit=1)[0])
    parser.add_argument("knead")
    parser.add_argument("--assimp", action="store_true")
    parser.add_argument("--blender", action="store_true")
    parser.add_argument("--keep")
    options = parser.parse_args()
    folder = os.path.abspath(options.keep or tempfile.mkdtemp(prefix="knead_wild_"))
    files = list(wild_files())
    if len({wild.name for wild in files}) != len(files) or len(files) < 300:
        raise SystemExit(f"{len(files)} files, some with the same name")
    try:
        check = Check(options.knead, folder, options.assimp)
        check.image_of(p for wild in files for p in wild.points)
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            failures = [(w.file, f) for w, f in zip(files, pool.map(check.failure, files)) if f]
        if options.blender:
            failures += check.opened_by_blender([w for w in files if w.file not in dict(failures)])
        for name, failure in failures:
            print(f"{name}: {failure.strip()}")
        print(f"{len(files)} files, {len(failures)} failed")
        return 1 if failures else 0
    finally:
        if not options.keep:
            shutil.rmtree(folder)


if __name__ == "__main__":
    sys.exit(main())
