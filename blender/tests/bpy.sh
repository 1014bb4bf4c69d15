#!/usr/bin/env bash
# Runs the headless tests in Blender as a module of Python, for versions that Debian does not have:
#   bpy.sh ADDON.zip PYTHON     such as the python of a venv with `pip install 'bpy>=4.2,<4.6' numpy` (Python 3.11)
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
export KNEAD=${KNEAD:-$here/../../build/release/knead}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export BLENDER_USER_CONFIG=$scratch/config BLENDER_USER_SCRIPTS=$scratch/scripts PYTHONDONTWRITEBYTECODE=1
mkdir -p "$BLENDER_USER_CONFIG" "$BLENDER_USER_SCRIPTS/addons"
python3 -m zipfile -e "$1" "$BLENDER_USER_SCRIPTS/addons"
"$2" -c 'import bpy; print("bpy", bpy.app.version_string)'
for test in operators tools poses shown; do
  "$2" "$here/test_$test.py"
done
