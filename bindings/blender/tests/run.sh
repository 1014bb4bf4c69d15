#!/usr/bin/env bash
# Installs the zip in an empty folder of settings and runs a test inside Blender:  run.sh ADDON.zip TEST.py
# KNEAD names the command (default: build/release/knead). Exit status 77: Blender is not installed.
set -euo pipefail

command -v blender >/dev/null || {
  echo "skipped: Blender is not installed; on Debian: apt-get install blender"
  exit 77
}
zip=$(realpath "$1")
test=$(realpath "$2")
export KNEAD=${KNEAD:-$(dirname "${BASH_SOURCE[0]}")/../../../build/release/knead}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
export BLENDER_USER_CONFIG=$scratch/config BLENDER_USER_SCRIPTS=$scratch/scripts PYTHONDONTWRITEBYTECODE=1
mkdir -p "$BLENDER_USER_CONFIG" "$BLENDER_USER_SCRIPTS/addons"
blender -b --factory-startup --python-exit-code 3 --python-expr \
  "import bpy; bpy.ops.preferences.addon_install(filepath='$zip'); bpy.ops.preferences.addon_enable(module='knead_blender')" \
  >"$scratch/install.log" 2>&1 || {
  cat "$scratch/install.log"
  exit 1
}
blender -b --factory-startup --python-exit-code 3 --python "$test"

# Uninstalled, nothing of it is left.
blender -b --factory-startup --python-exit-code 3 --python-expr "import bpy
bpy.ops.preferences.addon_enable(module='knead_blender')
assert hasattr(bpy.types.Object, 'knead')
with bpy.context.temp_override(area=bpy.context.window_manager.windows[0].screen.areas[0]):
    bpy.ops.preferences.addon_remove(module='knead_blender')
assert not hasattr(bpy.types.Object, 'knead')" >"$scratch/remove.log" 2>&1 || {
  cat "$scratch/remove.log"
  exit 1
}
[[ ! -e $BLENDER_USER_SCRIPTS/addons/knead_blender ]] || {
  echo "uninstalling left $BLENDER_USER_SCRIPTS/addons/knead_blender"
  exit 1
}
