#!/usr/bin/env bash
# Installs the zip in an empty folder of settings and runs a test in Blender's window, on a display of its own:
#   window.sh ADDON.zip TEST.py [ARGUMENTS]
# KNEAD names the command (default: build/release/knead); KNEAD_WINDOW the size of the display, such as 1280x800. Exit status 77: Blender or Xvfb is not installed.
set -euo pipefail

for program in blender Xvfb; do
  command -v "$program" >/dev/null || {
    echo "skipped: $program is not installed; on Debian: apt-get install blender xvfb"
    exit 77
  }
done
zip=$(realpath "$1")
test=$(realpath "$2")
shift 2
export KNEAD=${KNEAD:-$(dirname "${BASH_SOURCE[0]}")/../../../build/release/knead}
scratch=$(mktemp -d)
x_server=
stop() {
  if [[ -n $x_server ]]; then kill "$x_server" 2>/dev/null || true; fi
  rm -rf "$scratch"
}
trap stop EXIT
export BLENDER_USER_CONFIG=$scratch/config BLENDER_USER_SCRIPTS=$scratch/scripts PYTHONDONTWRITEBYTECODE=1
mkdir -p "$BLENDER_USER_CONFIG" "$BLENDER_USER_SCRIPTS/addons"
python3 -m zipfile -e "$zip" "$BLENDER_USER_SCRIPTS/addons"

mkfifo "$scratch/display"
Xvfb -displayfd 3 -screen 0 "${KNEAD_WINDOW:-800x600}x24" -nolisten tcp 3>"$scratch/display" 2>/dev/null &
x_server=$!
read -r display <"$scratch/display"
read -ra size <<<"$(tr x " " <<<"${KNEAD_WINDOW:-800x600}")"
export DISPLAY=:$display LIBGL_ALWAYS_SOFTWARE=1
timeout 400 blender --factory-startup --enable-event-simulate --no-window-focus --window-geometry 0 0 "${size[@]}" \
  --python-exit-code 3 --addons knead_blender --python "$test" -- "$@" >"$scratch/log" 2>&1 || true
cat "$scratch/log"
grep -q '^WINDOW TEST PASSED$' "$scratch/log"
