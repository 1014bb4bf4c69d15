#!/usr/bin/env bash
# Plays a corrected character in three.js:  gltf_player.sh KNEAD
# KNEAD_THREE names three's folder (npm install three; its folder is node_modules/three). Exit status 77: node or three
# is missing.
set -euo pipefail

knead=$(realpath "$1")
command -v node >/dev/null || {
  echo "skipped: node is not installed"
  exit 77
}
three=${KNEAD_THREE:-$(npm root -g 2>/dev/null || true)/three}
[[ -f $three/build/three.module.js ]] || {
  echo "skipped: three.js was not found; npm install three, and set KNEAD_THREE to its folder"
  exit 77
}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
node "$(dirname "${BASH_SOURCE[0]}")/gltf_player.mjs" "$knead" "$three" "$scratch"
