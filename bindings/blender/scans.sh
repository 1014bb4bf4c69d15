#!/usr/bin/env bash
# Changes three scans in Blender's window, tests the tools there, and renews the pictures of docs/blender/:
#   scans.sh FOLDER_OF_THE_MODULE FOLDER_OF_MESHES [FOLDER_OF_PICTURES]
# Needs Blender, Xvfb and ImageMagick; KNEAD names the command.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
meshes=$(realpath "$2")
pictures=$(realpath -m "${3:-$here/../../docs/blender}")
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
"$here/build.sh" "$1" "$scratch/knead_blender.zip"
KNEAD_WINDOW=1280x900 "$here/tests/window.sh" "$scratch/knead_blender.zip" "$here/scans.py" "$scratch" "$meshes"
mkdir -p "$pictures" "$scratch/tools"
for picture in "$scratch"/*.png; do
  convert "$picture" -crop 1057x786+0+27 +repage -resize 560x -quality 82 "$pictures/$(basename "${picture%.png}").jpg"
done

KNEAD_WINDOW=1280x900 "$here/tests/window.sh" "$scratch/knead_blender.zip" "$here/tests/test_window.py" "$scratch/tools"
tools=()
for tool in pull paint rotate stretch twist bend stamp; do tools+=("$scratch/tools/$tool.png[560x640+250+100]"); done
montage "${tools[@]}" -tile 4x -geometry 280x320+2+2 -quality 82 "$pictures/tools.jpg"
convert "$scratch/tools/redo.png" -crop 760x560+240+190 +repage -resize 55% -quality 82 "$pictures/redo.jpg"
