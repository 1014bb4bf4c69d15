#!/usr/bin/env bash
# Changes three scans in Blender's window and renews the pictures of docs/blender/:
#   scans.sh FOLDER_OF_THE_MODULE FOLDER_OF_MESHES [FOLDER_OF_PICTURES]
# Needs Blender, Xvfb and ImageMagick; KNEAD names the command.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
meshes=$(realpath "$2")
pictures=$(realpath -m "${3:-$here/../docs/blender}")
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
"$here/build.sh" "$1" "$scratch/knead_blender.zip"
KNEAD_WINDOW=1280x900 "$here/tests/window.sh" "$scratch/knead_blender.zip" "$here/scans.py" "$scratch" "$meshes"
mkdir -p "$pictures"
for picture in "$scratch"/*.png; do
  convert "$picture" -crop 1057x786+0+27 +repage -resize 560x -quality 82 "$pictures/$(basename "${picture%.png}").jpg"
done
