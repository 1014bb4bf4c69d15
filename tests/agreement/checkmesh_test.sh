#!/usr/bin/env bash
# Whether `knead check` and OpenFOAM's checkMesh say the same of a volume mesh: a quarter of a pipe that gmsh meshes, as
# it is and deformed beside walls that slide, as gmsh's file and as OpenFOAM's.
#   checkmesh_test.sh KNEAD
# Ends with 77 where gmsh or OpenFOAM is not installed (Debian: gmsh, openfoam).
set -euo pipefail

knead=$(realpath "$1")
for program in gmsh gmshToFoam checkMesh python3; do
  command -v "$program" > /dev/null || { echo "skipped: $program is not installed"; exit 77; }
done
export WM_PROJECT_DIR=${WM_PROJECT_DIR:-/usr/share/openfoam}

folder=$(mktemp -d)
trap 'rm -r "$folder"' EXIT
cd "$folder"

cat > pipe.geo << 'END'
SetFactory("OpenCASCADE");
Cylinder(1) = {0, 0, 0, 0, 0, 2, 0.5, Pi/2};
Physical Surface("wall") = {1};
Physical Surface("outlet") = {2};
Physical Surface("inlet") = {3};
Physical Surface("y0") = {4};
Physical Surface("x0") = {5};
Physical Volume("fluid") = {1};
Mesh.MeshSizeMax = 0.12;
END
gmsh -3 -format msh22 pipe.geo -o pipe.msh > gmsh.log

cat > turn.knead << 'END'
{"knead": 1, "walls": [{"patch": "wall", "slide": true}, {"patch": "x0", "slide": true}, {"patch": "y0", "slide": true}, {"patch": "inlet", "slide": true}, {"patch": "outlet", "slide": true}]}
{"tool": "rotate", "center": [0.2, 0.2, 1], "axis": [1, -1, 0.3], "angle_deg": 6, "inner": 0.1, "outer": 0.9}
END

mkdir -p case/system case/constant
head='FoamFile { version 2.0; format ascii; class dictionary; object dictionary; }'
echo "$head application checkMesh; startFrom startTime; startTime 0; stopAt endTime; endTime 1; deltaT 1; \
writeControl timeStep; writeInterval 1; writePrecision 17; writeFormat ascii;" > case/system/controlDict
echo "$head ddtSchemes {} gradSchemes {} divSchemes {} laplacianSchemes {} interpolationSchemes {} snGradSchemes {}" \
  > case/system/fvSchemes
echo "$head" > case/system/fvSolution
gmshToFoam -case case pipe.msh > foam.log

# Compares what `knead check` says of one mesh, in two formats, with what checkMesh says.
compare() {
  checkMesh -case case > check.log
  "$knead" check case/constant/polyMesh/points --json > foam.json
  "$knead" check "$1" --json > gmsh.json
  python3 - << 'END'
import json
import re

log = open("check.log").read()
number = r"([-+.\de]+)"
angle = re.search(rf"non-orthogonality Max: {number} average: {number}", log)
wanted = {
    "cells": int(re.search(r"cells: +(\d+)", log)[1]),
    "max_non_orthogonality_deg": float(angle[1]),
    "mean_non_orthogonality_deg": float(angle[2]),
    "max_skewness": float(re.search(rf"Max skewness = {number}", log)[1]),
    "max_aspect_ratio": float(re.search(rf"Max aspect ratio = {number}", log)[1]),
}
for file in ("gmsh.json", "foam.json"):
    found = json.load(open(file))["volume_cells"]
    assert found["inverted"] == 0, found
    for key, value in wanted.items():
        assert abs(found[key] - value) <= 1e-6 * value, (file, key, found[key], value)
print(wanted)
END
}
compare pipe.msh
before=$(cat gmsh.json)
"$knead" deform pipe.msh turn.knead -q -o turned.msh
"$knead" deform case/constant/polyMesh/points turn.knead -q -o case/constant/polyMesh/points
compare turned.msh
[[ $(cat gmsh.json) != "$before" ]] || { echo "nothing has moved"; exit 1; }
