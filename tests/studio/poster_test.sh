#!/usr/bin/env bash
# A poster of Studio has the same bytes as the picture of `knead render`, for each material and from all around.
#   poster_test.sh KNEAD KNEAD_STUDIO
# Exit status 77 where there is no OpenGL.
set -euo pipefail

knead=$1
studio=$2
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
export HOME=$work XDG_STATE_HOME=$work/state XDG_CONFIG_HOME=$work/config LIBGL_ALWAYS_SOFTWARE=1
cd "$work"

die() {
  echo "$(basename "$0"): $*" >&2
  exit 1
}

"$knead" make hand -n 6000 -o hand.ply -q
"$knead" render hand.ply -o try.png --size 16x16 --quality draft -q 2>try.log || {
  grep -q OpenGL try.log || die "$(cat try.log)"
  echo "there is no OpenGL: skipped"
  exit 77
}

# poster NAME SHOW POSTER WORDS...: SHOW and POSTER go to the script, WORDS to the command.
poster() {
  local name=$1 show=$2 how=$3
  shift 3
  printf '%s\n' '{"size": [800, 600]}' '{"open": "hand.ply"}' \
    '{"tool": "ball"}' '{"set": {"radius": 0.4}}' '{"drag": [[400, 300], [440, 280]], "steps": 3}' '{"wait": true}' \
    "$show" '{"view": {"yaw_deg": -30, "pitch_deg": 12.5, "field_of_view_deg": 40}}' \
    "{\"poster\": \"$name.png\", \"width\": 200, \"height\": 120$how}" '{"export": "pulled.ply"}' >"$name.script"
  "$studio" --script "$name.script" 2>"$name.log" || die "$name: $(cat "$name.log")"
  "$knead" render pulled.ply --view=-30,12.5 --perspective 40 --size 200x120 -q "$@"
}

poster plain '{"show": {"material": "clay", "cavity": false}}' '' -o wanted.png --background transparent
cmp plain.png wanted.png || die "the poster differs from the picture of the command"
poster jade '{"show": {"matcap": "jade", "occlusion": true}}' ', "ground": false, "transparent": false' \
  -o wanted.png --material jade --cavity --occlusion --no-ground --background gradient
cmp jade.png wanted.png || die "the poster in jade differs from the picture of the command"
! cmp -s plain.png jade.png || die "two posters that should differ are the same"
poster turn '{"show": {"material": "flat", "cavity": false, "wireframe": true}}' ', "pictures": 3' \
  -o 'wanted_%04d.png' --flat --wireframe --background transparent --turntable 3
for k in 0 1 2; do
  cmp "turn_000$k.png" "wanted_000$k.png" || die "picture $k from all around differs from that of the command"
done
[[ ! -e turn_0003.png && ! -e turn.png ]] || die "there are more pictures than asked for"
echo "passed"
