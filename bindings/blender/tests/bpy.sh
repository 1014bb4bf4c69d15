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
version=$("$2" -c 'import bpy; print(bpy.app.version_string)' | tail -1)
echo "bpy $version"
kind="add-on's zip"
if [[ $(python3 -m zipfile -l "$zip") == *blender_manifest.toml* ]]; then
  "$2" "$here/install_extension.py" "$zip"
  export KNEAD_ADDON=bl_ext.user_default.knead
  kind=extension
else
  python3 -m zipfile -e "$zip" "$BLENDER_USER_SCRIPTS/addons"
fi
tests=(operators tools poses shown correctives)
for test in "${tests[@]}"; do
  "$2" "$here/test_$test.py" 2>&1 | tee -a "$scratch/report.txt"
done
passed=$(awk '/^Ran [0-9]+ tests? in/ { sum += $2 } END { print sum }' "$scratch/report.txt")
cd "$here/../../.."
# shellcheck source=tools/packaging/zig.sh
source tools/packaging/zig.sh
zig_fact "$(uname -m)-linux-gnu.2.17" "$kind, bpy $version" built "$(stat -c %s "$zip" | numfmt --to=si)B"
zig_fact "$(uname -m)-linux-gnu.2.17" "$kind, bpy $version" started yes
zig_fact "$(uname -m)-linux-gnu.2.17" "$kind, bpy $version" tests "$passed passed (${tests[*]})"
