#!/usr/bin/env python3
"""Files that Knead writes, opened by assimp, OpenMesh and Blender. Run by hand; not part of ctest.

    /usr/bin/python3 tests/surveys/check_opened_elsewhere.py build/release/knead ../shared/meshes

Every shape is deformed by a pull and a twist and written into its own format and all others. What each program reads
is compared with the deformed shape as an OBJ file, read by a few lines of Python: positions, faces and their
orientation, uv, colours, normals; area and volume with `knead info`. The unchanged shape goes through the same in its
own format ("as is"), so that what Knead reads is compared too. Without the folder of meshes: the shapes of
`knead make` only.

Options: --only NAME (shapes whose name contains it), --program NAME, --keep DIR.
Exit code 0: no difference that is not listed with its reason in opened_elsewhere/known.py.
"""
import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from opened_elsewhere import compare, known, programs, shapes  # noqa: E402

MADE = ["sphere", "box", "cylinder", "torus", "hand", "crater", "knot", "letter-y"]
REAL = ["originals/spider/spider.obj", "originals/pirate_quads_normals_uv.obj", "originals/spot_quads_uv.obj",
        "originals/fuze.obj", "originals/cube_with_vertexcolors.obj", "originals/concave_polygon.obj",
        "originals/negative_indices.obj", "originals/icosahedron_ascii.stl", "originals/icosahedron_binary.stl",
        "originals/spider_ascii.stl", "originals/spider_binary.stl", "originals/featuretype_binary.stl",
        "originals/fandisk_quads.off", "originals/cow.off", "originals/fairing_cross_binary.off",
        "originals/dragon_res4_ascii.ply", "originals/suzanne_ngons_normals_uv_ascii.ply",
        "originals/reference_vertex_colors.ply", "originals/fixed_top_face_colors.ply",
        "originals/float_color_ascii.ply", "originals/cow_tristrips.ply", "originals/torus_big_endian_double.ply",
        "originals/duck.glb", "originals/box_textured.glb", "originals/cube_vertex_colors.glb",
        "camel_22k_nonmanifold.ply", "moebius_open.ply", "armadillo_173k_constructed.ply"]
FORMATS = ["ply", "obj", "glb", "stl", "off", "xyz"]


class Knead:
    def __init__(self, path):
        self.path = os.path.abspath(path)

    def __call__(self, *words):
        done = subprocess.run([self.path, *words], capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"knead {' '.join(words)}: {done.stderr}")
        return done.stdout

    def info(self, path):
        return json.loads(self("info", path, "--json"))


def write_session(path, info):
    """The corner of the box that is up is pulled out, then half of the shape is twisted."""
    low, high, size = info["box_min"], info["box_max"], info["diagonal"]
    middle = [(a + b) / 2 for a, b in zip(low, high)]
    top = [middle[0], high[1], middle[2]]
    pull = {"tool": "implicit", "inner": 0.1 * size, "outer": 0.4 * size,
            "path": [top, [top[0] + 0.05 * size, top[1] + 0.1 * size, top[2]]]}
    twist = {"tool": "twist", "center": middle, "axis": [0, 1, 0], "rate_deg": 60 / size, "inner": -0.2 * size,
             "outer": 0.2 * size}
    with open(path, "w", encoding="utf-8") as file:
        file.write("\n".join(json.dumps(line) for line in ({"knead": 1}, pull, twist)) + "\n")


class Check:
    def __init__(self, knead, folder, only_program):
        self.knead, self.folder = knead, folder
        self.programs = [p for p in programs.READS if only_program in (None, p)]
        self.failures, self.cells = 0, 0

    def shape(self, source):
        """All files of one shape."""
        name = os.path.basename(source)
        own = name.rsplit(".", 1)[1]
        self.moments(source, name, "as is", [own], '{"knead": 1}\n')
        self.moments(source, name, "deformed", FORMATS, None)

    def moments(self, source, name, moment, formats, session):
        path = os.path.join(self.folder, "session.knead")
        if session is None:
            write_session(path, self.knead.info(source))
        else:
            with open(path, "w", encoding="utf-8") as file:
                file.write(session)
        expected_path = os.path.join(self.folder, "expected.obj")
        report = json.loads(self.knead("deform", source, path, "-q", "--json", "-o", expected_path))
        if session is None and not report["moved_vertices"]:
            raise SystemExit(f"{name}: nothing moved")
        expected = shapes.read_obj(expected_path)
        for kind in formats:
            if kind == "stl" and not len(expected.sizes):
                continue
            # In the folder of the source's material files, which an OBJ file names.
            out = os.path.join(self.folder, "out", name.rsplit(".", 1)[0] + "." + kind)
            self.knead("deform", source, path, "-q", "-o", out)
            for program in self.programs:
                if kind in programs.READS[program]:
                    self.cell(known.File(name, own_format(name), kind, moment), program, out, expected)

    def cell(self, file, program, path, expected):
        info = self.knead.info(path)
        got, complaints = programs.read(program, self.folder, path)
        lines = complaints if got is None else self.differences(file, program, expected, got, info) + complaints
        excused = [(line, known.reason(program, file, line)) for line in lines]
        bad = [line for line, why in excused if not why]
        reasons = sorted({why for _, why in excused if why})
        self.cells += 1
        self.failures += bool(bad)
        result = "; ".join(bad[:3]) if bad else "ok" + "".join(f" [{why}]" for why in reasons)
        result = "DIFFERS: " * bool(bad) + result
        print(f"{file.name:38} {file.moment:9} {file.format:4} {program:9} {result}", flush=True)


    def differences(self, file, program, expected, got, info):
        wanted, bars = known.as_read(program, file, expected, compare.ATTRIBUTE_BARS)
        if len(wanted.sizes) < len(expected.sizes) and (wanted.sizes == 3).all():
            area, volume = compare.area_and_volume(wanted)
            info = info | {"area": area, "volume": info["volume"] and volume}
        # An STL file keeps its own normals, right or wrong, where a triangle did not move.
        is_new = file.format == "stl" and file.source_format != "stl"
        lines = compare.facet_normals(got, compare.bar_of(expected)) if is_new else []
        return lines + compare.compare(wanted, known.as_written(program, file, got), info, bars)


def own_format(name):
    return name.rsplit(".", 1)[1]


def sources(knead, folder, meshes, only):
    for kind in MADE:
        path = os.path.join(folder, kind + ".ply")
        knead("make", kind, "-q", "-o", path)
        yield path
    points = os.path.join(folder, "points.xyz")
    knead("deform", os.path.join(folder, "torus.ply"), write_empty(folder), "-q", "-o", points)
    yield points
    for name in REAL if meshes else []:
        if os.path.exists(os.path.join(meshes, name)):
            yield os.path.abspath(os.path.join(meshes, name))
        elif only is None:
            print(f"{name}: not there, left out")


def write_empty(folder):
    path = os.path.join(folder, "empty.knead")
    with open(path, "w", encoding="utf-8") as file:
        file.write('{"knead": 1}\n')
    return path


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("knead", nargs="?", default="build/release/knead")
    parser.add_argument("meshes", nargs="?")
    parser.add_argument("--only")
    parser.add_argument("--program", choices=list(programs.READS))
    parser.add_argument("--keep")
    options = parser.parse_args()
    folder = os.path.abspath(options.keep or tempfile.mkdtemp(prefix="knead_opened_"))
    os.makedirs(os.path.join(folder, "out"), exist_ok=True)
    try:
        wanting = programs.build(folder)
        if wanting:
            raise SystemExit(wanting)
        check = Check(Knead(options.knead), folder, options.program)
        for source in sources(check.knead, folder, options.meshes, options.only):
            if options.only is None or options.only in source:
                check.shape(source)
        print(f"{check.cells} files opened, {check.failures} of them differ")
        return 1 if check.failures or not check.cells else 0
    finally:
        if not options.keep:
            shutil.rmtree(folder)


if __name__ == "__main__":
    sys.exit(main())
