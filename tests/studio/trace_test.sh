#!/usr/bin/env bash
# What Studio and the graphics driver say to each other while the card moves the shape under a hand: every OpenGL call is
# written down by apitrace, and those of the frames of a drag are counted. None may read anything back.
#   trace_test.sh KNEAD KNEAD_STUDIO [SHAPE]
# Exit status 77 where Xvfb, xdotool or apitrace is missing.
set -euo pipefail

knead=$1
studio=$2
shape=${3:-}
# shellcheck disable=SC2034  # for the functions
pictures=
# shellcheck source=tests/studio/at_a_window.sh
source "$(dirname "$0")/at_a_window.sh"
need Xvfb xdotool apitrace

if [[ -z $shape ]]; then
  shape=$work/hand.ply
  "$knead" make hand -n 6000 -o "$shape" -q
fi

start_display
under=(apitrace trace -o "$work/studio.trace")
start_studio --backend gpu "$shape"
wait_for "the window" has_title "$(basename "$shape")"
sleep 2
before=$(journal_lines)
# First some pictures with nothing to be done, in which a slow driver makes Studio draw more simply.
for ((k = 0; k < 12; ++k)); do xdotool mousemove $((527 + k)) 459 sleep 0.2; done
xdotool mousemove 565 497 sleep 0.5 mousedown 1 sleep 0.5
for ((k = 1; k <= 12; ++k)); do # the next when the one before is done, however slow the machine is
  last=$(journal_lines)
  xdotool mousemove $((565 + 5 * k)) $((497 + 3 * k)) sleep 0.3
  for ((i = 0; i < 100; ++i)); do
    if has_grown "$last"; then break; fi
    sleep 0.1
  done
done
xdotool sleep 0.5 mouseup 1 sleep 2
has_grown "$before" || die "the drag leaves nothing in the journal"
if [[ -n ${3:-} ]]; then # of a large shape, only the trace: dialogs at few frames a second are hard to answer
  kill "$window"
  wait "$window" 2>/dev/null || true
  window=
else
  answer ctrl+s "$work/made.knead"
  answer ctrl+e "$work/made.ply"
  quit
  "$knead" deform "$shape" "$work/made.knead" --keep-mesh -o "$work/replayed.ply" -q
  cmp "$work/made.ply" "$work/replayed.ply" || die "the saved session gives another shape than the one on the screen"
fi

# A frame of the drag: one in which compute shaders move the vertices, place them and make their normals. It ends where the
# picture goes to the window, since apitrace does not see how GLFW 3.4 swaps buffers.
apitrace dump --color=never "$work/studio.trace" 2>/dev/null | awk '
/ glDispatchCompute\(/ { ++calls }
/ gl(ReadPixels|GetBufferSubData|GetNamedBufferSubData|MapBuffer|MapBufferRange|GetTexImage|Finish|ClientWaitSync|GetQueryObject[a-z0-9]*)\(/ { ++reads }
/ gl(Named)?Buffer(Sub)?Data\(/ && match($0, /size = [0-9]+/) { sent += substr($0, RSTART + 7, RLENGTH - 7) }
/ glClear\(mask = GL_COLOR_BUFFER_BIT\)/ {
  if (calls >= 3) { ++frames; all_reads += reads; if (sent > most) most = sent }
  calls = reads = sent = 0
}
END {
  printf "%d frames of a drag; %d calls that read back or wait; at most %d bytes sent in a frame\n", frames, all_reads, most
  exit !(frames >= 4 && all_reads == 0)
}'
echo "passed"
