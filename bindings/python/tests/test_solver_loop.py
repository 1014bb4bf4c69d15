"""The loop of examples/solver: with OpenFOAM where it is installed, and with a stand-in for SU2_CFD."""

import os
import pathlib
import shutil
import subprocess
import sys

import pytest
from conftest import COMMAND, SOURCE

LOOP = SOURCE / "examples/solver/loop.py"

# Its result is the square of the second point's height, plus 1 unless it starts from an earlier run as it should.
STAND_IN = """#!{python}
import pathlib, sys
keys = dict("".join(line.split()).split("=") for line in open(sys.argv[1]) if "=" in line)
lines = open(keys["MESH_FILENAME"]).read().split("\\n")
first = next(i for i, line in enumerate(lines) if line.startswith("NPOIN")) + 1
height = float(lines[first + 1].split()[1])
restart = pathlib.Path(keys["SOLUTION_FILENAME"])
wrong = (keys["RESTART_SOL"] == "YES") != restart.exists()
pathlib.Path(keys["RESTART_FILENAME"]).write_text("fields")
print("iterations")
rows = ['"Inner_Iter",    "CD"   ', "0, 9", f"1, {{height**2 + wrong}}"]
pathlib.Path(keys["CONV_FILENAME"] + ".csv").write_text("\\n".join(rows) + "\\n")
"""
SESSION = """{"knead": 1, "parameters": {"height": 0.1}}
{"tool": "implicit", "path": [[1, 0, 0], [1, "$height", 0]], "inner": 0.1, "outer": 0.9}
"""


@pytest.fixture
def su2(tmp_path):
    points = [(x, y) for y in (0, 1, 2) for x in (0, 1, 2)]
    cells = [(i, i + 1, i + 4, i + 3) for i in (0, 1, 3, 4)]
    (tmp_path / "a.su2").write_text("\n".join(
        ["NDIME= 2", "NELEM= 4", *(f"9 {a} {b} {c} {d}" for a, b, c, d in cells), "NPOIN= 9",
         *(f"{x} {y} {i}" for i, (x, y) in enumerate(points)), "NMARK= 0", ""]))
    (tmp_path / "a.cfg").write_text("SOLVER= EULER\nMESH_FILENAME= a.su2\nRESTART_SOL= NO\n")
    (tmp_path / "bump.knead").write_text(SESSION)
    (tmp_path / "bin").mkdir()
    program = tmp_path / "bin/SU2_CFD"
    program.write_text(STAND_IN.format(python=sys.executable))
    program.chmod(0o755)
    return tmp_path


def loop(folder, *arguments):
    path = os.pathsep.join([str(folder / "bin"), str(pathlib.Path(COMMAND).parent), os.environ["PATH"]])
    environment = {"WM_PROJECT_DIR": "/usr/share/openfoam", **os.environ, "PATH": path}
    return subprocess.run([sys.executable, LOOP, *map(str, arguments)], cwd=folder, env=environment, capture_output=True,
                          text=True)


def last_value(done):
    assert done.returncode == 0, done.stderr
    return float(done.stdout.splitlines()[-1].split()[1]), float(done.stdout.splitlines()[-1].split()[-1])


def test_su2(su2):
    done = loop(su2, "su2", "a.cfg", "bump.knead", "height=0.05,0.4", "--result", "CD", "--target", 0.04)
    value, result = last_value(done)
    assert result == pytest.approx(0.04, rel=1e-3) and value == pytest.approx(0.2, rel=1e-3)
    assert (su2 / "a.cfg").read_text().endswith("RESTART_SOL= NO\n")


@pytest.mark.parametrize("change, code, complaint", [
    (["--target", 9], 3, "choose them so that 9 lies between"),
    (["--target", 0.04, "--result", "CL"], 1, "no column CL"),
    (["--target", 0.04, "--runs", 3], 4, "not found in 3 runs"),
])  # fmt: skip
def test_what_ends_the_loop(su2, change, code, complaint):
    done = loop(su2, "su2", "a.cfg", "bump.knead", "height=0.05,0.4", "--result", "CD", *change)
    assert done.returncode == code and complaint in done.stderr and len(done.stderr.splitlines()) == 1


def test_a_program_that_fails_is_named(su2):
    (su2 / "bin/SU2_CFD").write_text(f"#!{sys.executable}\nraise SystemExit(5)\n")
    done = loop(su2, "su2", "a.cfg", "bump.knead", "height=0.05,0.4", "--result", "CD", "--target", 0.25)
    assert done.returncode == 1 and "SU2_CFD ended with 5; see log.SU2_CFD" in done.stderr


def test_a_case_without_a_mesh_is_named(su2):
    (su2 / "case").mkdir()
    done = loop(su2, "openfoam", "case", "bump.knead", "height=0.05,0.4", "--result", "p", "--target", 1)
    assert done.returncode == 3 and "case/constant/polyMesh: no mesh" in done.stderr and len(done.stderr.splitlines()) == 1


def test_openfoam(tmp_path):
    if not shutil.which("simpleFoam"):
        pytest.skip("OpenFOAM is not installed (Debian: openfoam)")
    shutil.copytree(SOURCE / "examples/solver/channel", tmp_path / "case")
    environment = {"WM_PROJECT_DIR": "/usr/share/openfoam", **os.environ}
    subprocess.run(["blockMesh", "-case", "case"], cwd=tmp_path, env=environment, check=True, capture_output=True)
    session = SOURCE / "examples/solver/channel.knead"
    done = loop(tmp_path, "openfoam", "case", session, "height=0.1,0.5", "--result", "inletPressure", "--target", 2)
    value, result = last_value(done)
    assert result == pytest.approx(2, rel=1e-3) and 0.39 < value < 0.42
    judged = subprocess.run(["checkMesh", "-case", "case", "-constant"], cwd=tmp_path, env=environment, capture_output=True,
                            text=True)
    assert "Mesh OK." in judged.stdout and "All edges aligned with or perpendicular to non-empty" in judged.stdout
