"""Writes every session of examples/ as an animation of each format, opens the files in other programs, and compares each
frame with the files that `--frames N -o F_%04d.ply` writes. Run by hand:

    KNEAD=build/release/knead python3 tests/surveys/animations/compare.py [--frames 5] [--vertices 6000] [SESSION...]

Each reader is used where it is there: Blender (PC2, MDD, glTF) as the program `blender`, OpenUSD (`pip install usd-core`),
VTK (`pip install pyvista`), three.js and Khronos' validator (`npm install three gltf-validator` in the folder NODE_FOLDER),
Chromium as the program `chromium` (`npm install playwright-core` there).
Meshes that are not part of the project come from KNEAD_TEST_MESHES. Needs numpy.
"""

import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
KNEAD = os.environ.get("KNEAD", "knead")
MESHES = pathlib.Path(os.environ.get("KNEAD_TEST_MESHES", ROOT.parent / "shared/meshes"))
KINDS = ("sphere", "box", "cylinder", "torus", "hand", "crater", "knot", "letter-y")


def knead(*words, folder):
    return subprocess.run([KNEAD, *map(str, words)], cwd=folder, capture_output=True, text=True)


def provide(name, folder, vertices):
    """Makes the shape of that name, or takes a real mesh. Returns whether it is there."""
    kind = pathlib.Path(name).stem.split("_")[0]
    if kind in KINDS and "50k" not in name:
        return knead("make", kind, "-n", vertices, "-q", "-o", name, folder=folder).returncode == 0
    if (MESHES / name).exists():
        shutil.copy(MESHES / name, folder / name)
    return (folder / name).exists()


def ply(path):
    """The vertices of a binary PLY file that Knead wrote: floats, or doubles."""
    data = path.read_bytes()
    begin = data.index(b"end_header\n") + 11
    header = data[:begin].decode()
    count = int(header.split("element vertex ")[1].split()[0])
    columns = [line.split()[1:] for line in header.split("element face")[0].splitlines() if line.startswith("property")]
    kinds = {"float": "<f4", "double": "<f8", "uchar": "u1", "int": "<i4", "uint": "<u4", "float32": "<f4", "uint8": "u1"}
    table = np.frombuffer(data, np.dtype([(name, kinds[kind]) for kind, name in columns]), count, begin)
    return np.stack([table[axis] for axis in "xyz"], axis=1).astype(np.float64)


def read_caches(folder, frames):
    pc2 = (folder / "o.pc2").read_bytes()
    yield "PC2", np.frombuffer(pc2, "<f4", offset=32).reshape(frames, -1, 3)
    mdd = (folder / "o.mdd").read_bytes()
    yield "MDD", np.frombuffer(mdd, ">f4", offset=8 + 4 * frames).reshape(frames, -1, 3)


def read_usd(folder, frames):
    from pxr import Usd, UsdGeom, UsdValidation

    stage = Usd.Stage.Open(str(folder / "o.usda"))
    validators = UsdValidation.ValidationRegistry().GetOrLoadAllValidators()
    errors = [error.GetErrorAsString() for error in UsdValidation.ValidationContext(validators).Validate(stage)]
    if errors or not validators:
        raise SystemExit(f"{folder / 'o.usda'}: {errors[:3]}, by {len(validators)} validators")
    points = UsdGeom.PointBased(stage.GetDefaultPrim()).GetPointsAttr()
    yield "OpenUSD", [np.array(points.Get(k)) for k in range(frames)]


def read_vtk(folder, _):
    import pyvista

    reader = pyvista.get_reader(folder / "o.pvd")
    shown = []
    for time in reader.time_values:
        reader.set_active_time_value(time)
        shown.append(np.array(reader.read()[0].points))
    yield "VTK", shown


def read_blender(folder, frames):
    script = ["blender", "-b", "--factory-startup", "--python-exit-code", "3", "--python", HERE / "in_blender.py", "--"]
    subprocess.run([*map(str, script), str(folder), str(frames)], check=True, capture_output=True)
    for kind in ("PC2", "MDD", "glTF"):
        yield "Blender, " + kind, np.load(folder / f"blender_{kind}.npy")


def read_three(folder, frames):
    node = pathlib.Path(os.environ["NODE_FOLDER"])
    for script in ("frames.mjs", "in_three.mjs", "in_chromium.mjs"):
        shutil.copy(HERE / script, node / script)
    has_chromium = shutil.which("chromium") and (node / "node_modules/playwright-core").exists()
    for program in ("three", *(["chromium"] if has_chromium else [])):
        words = ["node", f"in_{program}.mjs", folder / "o.glb", frames, folder / f"{program}.bin"]
        done = subprocess.run(list(map(str, words)), cwd=node, capture_output=True, text=True)
        if done.returncode != 0:
            raise SystemExit(f"in_{program}.mjs: {done.stderr[-500:]}")
        yield "three.js" if program == "three" else "Chromium", np.fromfile(folder / f"{program}.bin", "<f4").reshape(frames, -1, 3)


def volume_error(folder, frames):
    """The greatest difference of a frame's volume from the first one's; of an open shape 0."""
    volumes = [json.loads(knead("info", f"F_{k:04d}.ply", "--json", folder=folder).stdout)["volume"] for k in range(frames)]
    return max(abs(volume / volumes[0] - 1) for volume in volumes) if volumes[0] else 0.0


def compare(path, frames, vertices, programs):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        shutil.copy(path, folder / path.name)
        meshes = [json.loads(line).get("mesh") for line in path.read_text().splitlines()]
        if not all(provide(mesh, folder, vertices) for mesh in filter(None, meshes)):
            return {"skipped": "a mesh is absent"}
        words = ["deform", meshes[0], path.name, "--frames", frames, "-q", "-o"]
        made = knead(*words, "F_%04d.ply", folder=folder)
        if made.returncode != 0:
            return {"skipped": made.stderr.strip()}
        expected = [ply(folder / f"F_{k:04d}.ply") for k in range(frames)]
        for extension in ("pc2", "mdd", "glb", "usda", "pvd"):
            made = knead(*words, "o." + extension, folder=folder)
            if made.returncode != 0:
                return {"skipped": made.stderr.strip()}
        shutil.copy(folder / f"F_{0:04d}.ply", folder / "start.ply")
        size = np.linalg.norm(np.ptp(expected[0], axis=0))
        same_faces = all(len(e) == len(expected[0]) for e in expected)
        errors = {"volume": volume_error(folder, frames)}
        for program in (read_caches, *programs):
            for what, shown in program(folder, frames):
                if len(shown) != frames or (same_faces and len(shown[0]) < len(expected[0])):
                    raise SystemExit(f"{path.name}: {what} shows {len(shown)} frames of {len(shown[0])} vertices")
                compared = range(frames) if same_faces else [frames - 1]
                errors[what] = max(np.abs(shown[k][: len(expected[k])] - expected[k]).max() / size for k in compared)
        return errors


def available():
    programs = []
    for module, program in (("pxr", read_usd), ("pyvista", read_vtk)):
        try:
            __import__(module)
            programs.append(program)
        except ImportError:
            print(f"without {module}", file=sys.stderr)
    if shutil.which("blender"):
        programs.append(read_blender)
    if shutil.which("node") and "NODE_FOLDER" in os.environ:
        programs.append(read_three)
    return programs


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--frames", type=int, default=5)
    parser.add_argument("--vertices", type=int, default=6000, help="of procedural shapes")
    parser.add_argument("sessions", nargs="*", type=pathlib.Path)
    options = parser.parse_args()
    programs = available()
    worst = 0
    for path in options.sessions or sorted((ROOT / "examples").rglob("*.knead")):
        errors = compare(path, options.frames, options.vertices, programs)
        print(path.name, {key: value if isinstance(value, str) else float(f"{value:.2g}") for key, value in errors.items()},
              flush=True)  # fmt: skip
        worst = max([worst, *(v for key, v in errors.items() if key not in ("skipped", "volume"))])
    print(f"greatest difference: {worst:.2g} of the diagonal")
    return 0 if worst < 5e-7 else 1


if __name__ == "__main__":
    sys.exit(main())
