#!/usr/bin/env bash
# Runs the headless tests in Blender as a module of Python, for versions that Debian does not have:
#   bpy.sh ZIP PYTHON     such as the python of a venv with `pip install bpy==5.0.1 numpy` (Python 3.11; 5.2.3: 3.13)
# The zip is the add-on, for Python 3.11, or the extension, which is validated and installed as Blender does it.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
export KNEAD=${KNEAD:-$here/../../../build/release/knead}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export BLENDER_USER_CONFIG=$scratch/config BLENDER_USER_SCRIPTS=$scratch/scripts PYTHONDONTWRITEBYTECODE=1
export BLENDER_USER_EXTENSIONS=$scratch/extensions BLENDER_USER_DATAFILES=$scratch/datafiles
mkdir -p "$BLENDER_USER_CONFIG" "$BLENDER_USER_SCRIPTS/addons"
zip=$(realpath "$1")
"$2" -c 'import bpy; print("bpy", bpy.app.version_string)'
if [[ $(python3 -m zipfile -l "$zip") == *blender_manifest.toml* ]]; then
  "$2" "$here/install_extension.py" "$zip"
  export KNEAD_ADDON=bl_ext.user_default.knead
else
  python3 -m zipfile -e "$zip" "$BLENDER_USER_SCRIPTS/addons"
fi
for test in operators tools poses shown correctives; do
  "$2" "$here/test_$test.py"
done
