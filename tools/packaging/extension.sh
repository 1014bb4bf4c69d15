#!/usr/bin/env bash
# Makes the extension for Blender 4.2 and later of the wheels for 3.11 (Blender up to 5.0) and 3.13 (from 5.1 on):
#   extension.sh [FOLDER_OF_WHEELS [OUT.zip]]     (default: out/wheels, out/knead_extension.zip)
# What it holds is the add-on, GPL-3.0-or-later, and the wheels as they are.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
folder=$(realpath "${1:-$root/out/wheels}")
out=$(realpath -m "${2:-$root/out/knead_extension.zip}")
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
mkdir -p "$scratch/wheels" "$(dirname "$out")"
cp "$root"/bindings/blender/knead_blender/*.py "$root/bindings/blender/LICENSE" "$scratch"
python3 "$root/bindings/blender/icons.py" "$scratch/icons"

platforms=()
add() { # PLATFORM_OF_BLENDER PATTERN: of its wheels
  local older newer
  older=$(echo "$folder"/knead3d-*-cp311-cp311-"$2".whl)
  newer=$(echo "$folder"/knead3d-*-cp313-cp313-"$2".whl)
  if [[ -f $older && -f $newer ]]; then
    cp "$older" "$newer" "$scratch/wheels"
    platforms+=("\"$1\"")
  fi
}
add linux-x64 manylinux_2_17_x86_64
add windows-x64 win_amd64
add macos-arm64 macosx_11_0_arm64
add macos-x64 macosx_11_0_x86_64
[[ ${#platforms[@]} -gt 0 ]] || {
  echo "extension: $folder has no wheels of Python 3.11 and 3.13 for any platform of Blender; run: ./dev wheels" >&2
  exit 1
}

list() { (IFS=, && echo "$*"); }
wheels=()
for wheel in "$scratch"/wheels/*; do wheels+=("\"./wheels/$(basename "$wheel")\""); done
version=$(sed -n 's/^project(knead VERSION \([0-9.]*\).*/\1/p' "$root/CMakeLists.txt")
sed -e "s|@VERSION@|$version|" -e "s|@PLATFORMS@|$(list "${platforms[@]}")|" -e "s|@WHEELS@|$(list "${wheels[@]}")|" \
  "$root/bindings/blender/manifest.toml.in" >"$scratch/blender_manifest.toml"
rm -f "$out"
(cd "$scratch" && python3 -m zipfile -c "$out" ./*)
echo "$out"
