#!/usr/bin/env bash
# Knead Studio at a true window: Xvfb is the display, xdotool the hand. Starts, drags with every tool, undoes, saves,
# exports, dies, recovers, and is closed; what it writes is compared with what `knead deform` makes of the same session.
#   window_test.sh KNEAD KNEAD_STUDIO [FOLDER FOR PICTURES]
# Exit status 77 where Xvfb or xdotool is missing.
set -euo pipefail

knead=$1
studio=$2
pictures=${3:-}
# shellcheck source=tests/studio/at_a_window.sh
source "$(dirname "$0")/at_a_window.sh"
need Xvfb xdotool

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

# Of the hand as it is opened: the palm about (574, 564), the middle finger about (607, 308); nothing at (1000, 700).
xdotool key 6 sleep 2
click 494 554
use stamp 6 474 564 564 559
xdotool key Escape sleep 0.3 key 1 sleep 0.3
for ((i = 0; i < 4; ++i)); do xdotool key bracketleft sleep 0.2; done
use ball 1 583 592 611 611
use move q 583 592 588 580
use capsule 2 564 535 574 512
use paint 3 574 611 621 602
use print u 574 611 580 605
xdotool key 4 sleep 0.3
click 564 478
use points 4 564 478 574 497
xdotool key Escape sleep 0.3 key 5 sleep 0.3
drag 526 516 583 516
use curve 5 555 516 555 531
xdotool key Escape sleep 0.3 key p sleep 0.3
for place in "526 630" "628 650" "564 478"; do
  # shellcheck disable=SC2086  # two words
  click $place
done
use pose p 574 640 584 655
grep -q '"tool": "pose"' "$work"/state/knead/journals/*/session.knead || die "no pose in the journal"
xdotool key Escape sleep 0.3 key 7 sleep 0.3
click 574 678
use rotate 7 1000 700 1040 700
use stretch 8 1000 700 1040 700
# From the front the ring finger goes upwards in the picture, so that the limit cylinder is placed on it.
xdotool key Escape sleep 0.3 key alt+1 sleep 0.6 key 0 sleep 0.3
click 511 308
use bend 0 1000 700 1040 700
use twist 9 1000 700 1040 700
use bend_along a 700 700 700 300
grep -q '"tool": "implicit"' "$work"/state/knead/journals/*/session.knead || die "no implicit stroke in the journal"

before=$(journal_lines)
xdotool key Escape sleep 0.3 key ctrl+z
wait_for "undo" has_grown "$before"
grep -q '"undo"' "$work"/state/knead/journals/*/session.knead || die "no undo in the journal"

answer ctrl+e "$work/made.ply"
picture exported

# What is saved would not be offered again.
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

answer ctrl+s "$work/again.knead" desktop
wait_for "the title of the saved session" has_title '^again.knead - '
picture saved
# The pose of a palm that the tools before have crumpled may end on the way: the exit code is 4 then, and Studio shows the same shape.
"$knead" deform "$work/hand.ply" "$work/again.knead" --keep-mesh -o "$work/replayed.ply" -q || [[ $? -eq 4 ]]
cmp "$work/made.ply" "$work/replayed.ply" || die "the saved session gives another shape than the one on the screen"
quit
[[ -z $(ls "$work/state/knead/journals") ]] || die "a journal is left behind"
echo "passed"
