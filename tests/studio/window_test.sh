#!/usr/bin/env bash
# Knead Studio at a true window: Xvfb is the display, xdotool the hand. Starts, drags with every tool, undoes, saves,
# exports, dies, recovers, and is closed; what it writes is compared with what `knead deform` makes of the same session.
#   window_test.sh KNEAD KNEAD_STUDIO [FOLDER FOR PICTURES]
# Exit status 77 where Xvfb or xdotool is missing.
set -euo pipefail

knead=$1
studio=$2
pictures=${3:-}
for program in Xvfb xdotool; do
  command -v "$program" >/dev/null || {
    echo "$program is not installed: skipped"
    exit 77
  }
done

work=$(mktemp -d)
export HOME=$work XDG_STATE_HOME=$work/state XDG_CONFIG_HOME=$work/config LIBGL_ALWAYS_SOFTWARE=1
server=
window=

finish() {
  local status=$?
  [[ -z $window ]] || kill -9 "$window" 2>/dev/null || true
  [[ -z $server ]] || kill "$server" 2>/dev/null || true
  [[ $status -eq 0 ]] || { echo "failed; what Studio said:" && cat "$work/studio.log" 2>/dev/null; }
  rm -rf "$work"
}
trap finish EXIT

die() {
  echo "window_test: $*" >&2
  picture failed || true
  exit 1
}

# wait_for WHAT COMMAND...: until the command succeeds, for two minutes at most.
wait_for() {
  local what=$1
  shift
  for ((i = 0; i < 1200; ++i)); do
    if "$@" >/dev/null 2>&1; then return 0; fi
    kill -0 "$window" 2>/dev/null || die "Studio ended while waiting for $what"
    sleep 0.1
  done
  die "waited in vain for $what"
}

start_display() {
  : >"$work/number"
  Xvfb -noreset -displayfd 9 -screen 0 1440x900x24 9>"$work/number" >/dev/null 2>&1 &
  server=$!
  for ((i = 0; i < 600; ++i)); do
    DISPLAY=:$(<"$work/number")
    export DISPLAY
    if [[ $DISPLAY != : ]] && xdotool getmouselocation >/dev/null 2>&1; then return 0; fi
    sleep 0.1
  done
  die "Xvfb does not start"
}

start_studio() {
  "$studio" "$@" >"$work/studio.log" 2>&1 &
  window=$!
}

has_title() { xdotool search --name "$1"; }
picture() {
  if [[ -n $pictures ]] && command -v import >/dev/null; then import -window root "$pictures/$1.png"; fi
}

journal_lines() { cat "$work"/state/knead/journals/*/session.knead 2>/dev/null | wc -l; }
has_grown() { [[ $(journal_lines) -gt $1 ]]; }

# drag X0 Y0 X1 Y1: with the left button.
drag() {
  xdotool mousemove "$1" "$2" sleep 0.3 mousedown 1 sleep 0.1
  for ((k = 1; k <= 8; ++k)); do
    xdotool mousemove $(($1 + ($3 - $1) * k / 8)) $(($2 + ($4 - $2) * k / 8)) sleep 0.03
  done
  xdotool sleep 0.1 mouseup 1 sleep 0.3
}

# use TOOL KEY X0 Y0 X1 Y1: until the stroke is in the journal; what places a tool is done before.
use() {
  local before
  before=$(journal_lines)
  xdotool key "$2" sleep 0.3
  for ((try = 0; try < 4; ++try)); do
    drag "$3" "$4" "$5" "$6"
    for ((i = 0; i < 40; ++i)); do
      if has_grown "$before"; then
        picture "$1"
        return 0
      fi
      sleep 0.1
    done
  done
  die "$1 leaves nothing in the journal"
}

click() { xdotool mousemove "$1" "$2" sleep 0.3 click 1 sleep 0.6; }

# press KEY: long enough to be seen in a picture, however slowly they follow each other.
press() { xdotool keydown "$1" sleep 0.5 keyup "$1"; }

# answer KEY FILE: the file dialog that the key opens.
answer() {
  xdotool key "$1" sleep 2
  xdotool key ctrl+a sleep 0.3 type --delay 60 "$2"
  xdotool sleep 1
  press Return
  wait_for "$2" test -s "$2"
}

# Where the application was not built, one line says so.
mkdir "$work/alone"
cp "$knead" "$work/alone/knead"
status=0
PATH=$work/alone "$work/alone/knead" studio >"$work/studio.log" 2>&1 || status=$?
[[ $status -eq 1 && $(wc -l <"$work/studio.log") -eq 1 ]] || die "knead studio without the application: status $status"

start_display
"$knead" make hand -n 6000 -o "$work/hand.ply" -q
start_studio "$work/hand.ply"
wait_for "the window" has_title 'hand.ply'
sleep 1
picture start

# Of the hand as it is opened: the palm about (690, 570), the middle finger about (725, 300); nothing at (1000, 700).
xdotool key 6 sleep 2
click 606 560
use stamp 6 585 570 680 565
xdotool key Escape sleep 0.3
for ((i = 0; i < 4; ++i)); do xdotool key bracketleft sleep 0.2; done
use ball 1 700 600 730 620
use capsule 2 680 540 690 515
use paint 3 690 620 740 610
xdotool key 4 sleep 0.3
click 680 480
use points 4 680 480 690 500
xdotool key Escape sleep 0.3 key 5 sleep 0.3
drag 640 520 700 520
use curve 5 670 520 670 535
xdotool key Escape sleep 0.3 key 7 sleep 0.3
click 690 690
use rotate 7 1000 700 1040 700
use stretch 8 1000 700 1040 700
# From the front the ring finger goes upwards in the picture, so that it is found as the limb.
xdotool key Escape sleep 0.3 key alt+1 sleep 0.6 key 0 sleep 0.3
click 624 300
use bend 0 1000 700 1040 700
use twist 9 1000 700 1040 700
grep -q '"tool": "implicit"' "$work"/state/knead/journals/*/session.knead || die "no implicit stroke in the journal"

before=$(journal_lines)
xdotool key Escape sleep 0.3 key ctrl+z
wait_for "undo" has_grown "$before"
grep -q '"undo"' "$work"/state/knead/journals/*/session.knead || die "no undo in the journal"

answer ctrl+s "$work/made.knead"
answer ctrl+e "$work/made.ply"
picture saved
"$knead" deform "$work/hand.ply" "$work/made.knead" -o "$work/replayed.ply" -q
cmp "$work/made.ply" "$work/replayed.ply" || die "the saved session gives another shape than the one on the screen"

kill -9 "$window"
wait "$window" 2>/dev/null || true
start_studio
wait_for "the window" has_title 'new sphere'
sleep 2
picture offer
press Return
wait_for "recovery" has_title 'hand.ply'
sleep 1
answer ctrl+e "$work/recovered.ply"
picture recovered
cmp "$work/made.ply" "$work/recovered.ply" || die "the recovered work gives another shape than the one before"

answer ctrl+s "$work/again.knead"
wait_for "the title of the saved session" has_title '^again.knead - '
xdotool key ctrl+q
for ((i = 0; i < 300; ++i)); do
  kill -0 "$window" 2>/dev/null || break
  sleep 0.1
done
wait "$window" || die "Studio ends with status $?"
[[ -z $(ls "$work/state/knead/journals") ]] || die "a journal is left behind"
window=
echo "passed"
