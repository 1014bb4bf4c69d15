#!/usr/bin/env bash
# The demo that `./dev demo` runs. It makes a hand; the session peace.knead bends two of its fingers and paints a bump on
# its palm. Then it measures and draws the result. Everything is written into out/demo.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
knead=${KNEAD:-knead}
out=$(dirname "$here")/out/demo
mkdir -p "$out"

"$knead" make hand -o "$out/hand.ply"
"$knead" deform "$out/hand.ply" "$here/peace.knead" --report "$out/report.json" -o "$out/peace.ply"
"$knead" deform "$out/peace.ply" "$here/peace.knead" --inverse -q -o "$out/hand_again.ply"
drawn=
if "$knead" render "$out/hand.ply" "$out/peace.ply" --session "$here/peace.knead" --view 25,14 --size 1600x800 -q \
  -o "$out/before_after.png"; then
  drawn="  before_after.png   the hand with the tools of the session (left) and the result (right)
"
else
  printf 'There are no pictures (see above); everything else was made.\n' >&2
fi

cat <<END

Written to $out:
  hand.ply           the hand
  peace.ply          the hand deformed by $here/peace.knead
  report.json        volume error, moved vertices, steps, seconds
  hand_again.ply     peace.ply taken back by the same session
$drawn
Try next, with a shape of your own (PLY, OBJ, STL, OFF, GLB or XYZ):
  $knead info SHAPE
  cp "$here/peace.knead" mine.knead        each line is a stroke: change its numbers, add lines
  $knead deform SHAPE mine.knead -o OUT
  $knead render SHAPE OUT --session mine.knead -o picture.png
docs/session.md describes every tool, docs/command.md every option.
END
