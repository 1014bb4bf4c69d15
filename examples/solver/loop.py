#!/usr/bin/env python3
"""Morph, solve, repeat: finds the value of a session's parameter at which a solver's result is the target.

    loop.py openfoam CASE SESSION height=0.1,0.5 --result inletPressure --target 2
    loop.py su2 CASE.cfg SESSION height=0.1,0.5 --result CD --target 0.3

The result at the two values must lie on both sides of the target. The mesh keeps its numbering, so each run starts with
the fields of the run before.

OpenFOAM: CASE is a case with a mesh, whose controlDict has `startFrom latestTime`, names the application, and has a
function of the name RESULT that writes one number. The first mesh is kept in CASE/loop.start.
SU2: RESULT is a column of history.csv. The files that the runs use lie beside CASE.cfg and are named loop.*.

Needs Python 3.9, knead and the solver on the path. Ends with 0; 1: a program failed, or the result is not found; 3: bad
input; 4: too many runs.
"""

import argparse
import csv
import pathlib
import re
import shutil
import subprocess
import sys


class Failure(Exception):
    def __init__(self, text, code=1):
        super().__init__(text)
        self.code = code


def run(command, log, folder=None):
    """Runs a program, which writes to the file `log`."""
    with open(log, "w") as output:
        try:
            done = subprocess.run(command, stdout=output, stderr=subprocess.STDOUT, cwd=folder)
        except FileNotFoundError:
            raise Failure(f"{command[0]}: not found; install it, or add its folder to PATH") from None
    if done.returncode != 0:
        raise Failure(f"{command[0]} ended with {done.returncode}; see {log}")


def entry(text, pattern, where, what):
    found = re.search(pattern, text, re.M)
    if found is None:
        raise Failure(f"{where}: no {what}", 3)
    return found.group(1)


class OpenFoam:
    def __init__(self, case, result):
        self.case, self.result = pathlib.Path(case), result
        self.mesh, self.start = self.case / "constant/polyMesh", self.case / "loop.start"
        if not self.start.exists():
            if not self.mesh.is_dir():
                raise Failure(f"{self.mesh}: no mesh; make it first, for example with blockMesh", 3)
            shutil.copytree(self.mesh, self.start)
        control = self.case / "system/controlDict"
        self.application = entry(control.read_text(), r"^\s*application\s+(\w+)\s*;", control, "application")

    def morph(self, deform, value):
        run(deform(self.start / "points", self.mesh / "points", value), self.case / "log.knead")

    def solve(self):
        run([self.application, "-case", str(self.case)], self.case / f"log.{self.application}")
        runs = sorted((self.case / "postProcessing" / self.result).glob("*/*.dat"), key=lambda p: float(p.parent.name))
        lines = [line for line in (runs[-1].read_text().splitlines() if runs else []) if not line.startswith("#")]
        if not lines:
            raise Failure(f"{self.case}/postProcessing/{self.result}: no numbers; controlDict needs such a function")
        return float(lines[-1].split()[-1])


class Su2:
    def __init__(self, config, result):
        config = pathlib.Path(config)
        self.folder, self.text, self.result = config.parent, config.read_text(), result
        self.mesh = self.folder / entry(self.text, r"^\s*MESH_FILENAME\s*=\s*(\S+)", config, "MESH_FILENAME")
        self.config = self.folder / "loop.cfg"
        self.restarts = False

    def morph(self, deform, value):
        run(deform(self.mesh, self.folder / "loop.su2", value), self.folder / "log.knead")
        own = {"MESH_FILENAME": "loop.su2", "RESTART_FILENAME": "loop.dat", "SOLUTION_FILENAME": "loop.dat",
               "CONV_FILENAME": "loop", "TABULAR_FORMAT": "CSV", "RESTART_SOL": "YES" if self.restarts else "NO"}
        kept = [line for line in self.text.splitlines() if line.partition("=")[0].strip() not in own]
        self.config.write_text("\n".join([*kept, *(f"{key}= {value}" for key, value in own.items()), ""]))

    def solve(self):
        run(["SU2_CFD", self.config.name], self.folder / "log.SU2_CFD", self.folder)
        self.restarts = True
        with open(self.folder / "loop.csv", newline="") as history:
            rows = [[field.strip().strip('"') for field in row] for row in csv.reader(history)]
        if self.result not in rows[0]:
            raise Failure(f"loop.csv: no column {self.result}; HISTORY_OUTPUT chooses the columns")
        return float(rows[-1][rows[0].index(self.result)])


def search(evaluate, low, high, target, tolerance, runs):
    """Returns the value at which evaluate(value) is the target: by chords, of which both ends keep moving."""
    ends = [[low, evaluate(low) - target], [high, evaluate(high) - target]]
    if ends[0][1] * ends[1][1] > 0:
        raise Failure(f"the result is {ends[0][1] + target:.6g} and {ends[1][1] + target:.6g} at the two values; "
                      f"choose them so that {target:g} lies between", 3)
    last = None
    for _ in range(runs - 2):
        (a, at_a), (b, at_b) = ends
        value = a if at_a == at_b else b - at_b * (b - a) / (at_b - at_a)
        error = evaluate(value) - target
        if abs(error) <= tolerance * abs(target):
            return value
        side = 0 if error * at_a > 0 else 1
        ends[side] = [value, error]
        if side == last:
            ends[1 - side][1] /= 2
        last = side
    raise Failure(f"not found in {runs} runs", 4)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("solver", choices=["openfoam", "su2"])
    parser.add_argument("case")
    parser.add_argument("session")
    parser.add_argument("parameter", help="NAME=LOW,HIGH")
    parser.add_argument("--result", required=True, help="what the solver writes")
    parser.add_argument("--target", type=float, required=True)
    parser.add_argument("--tolerance", type=float, default=1e-3, help="beside the target (default: %(default)s)")
    parser.add_argument("--runs", type=int, default=12, help="how many runs at most (default: %(default)s)")
    asked = parser.parse_args()
    given = re.fullmatch(r"(\w+)=([^,]+),([^,]+)", asked.parameter)
    try:
        if given is None:
            raise Failure(f"{asked.parameter}: give a name and two values, as in height=0.1,0.5", 3)
        name, low, high = given.group(1), float(given.group(2)), float(given.group(3))
        solver = {"openfoam": OpenFoam, "su2": Su2}[asked.solver](asked.case, asked.result)

        def deform(source, target, value):
            return ["knead", "deform", str(source), asked.session, "--set", f"{name}={value!r}", "-o", str(target)]

        def evaluate(value):
            solver.morph(deform, value)
            result = solver.solve()
            print(f"{name} {value:.6g}  {asked.result} {result:.6g}", flush=True)
            return result

        search(evaluate, low, high, asked.target, asked.tolerance, asked.runs)
    except (Failure, OSError, ValueError) as error:
        print(f"loop.py: {error}", file=sys.stderr)
        return getattr(error, "code", 3)
    return 0


if __name__ == "__main__":
    sys.exit(main())
