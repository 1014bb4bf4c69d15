#!/usr/bin/env bash
# The demo that `./dev demo` runs: a creature's head out of a sphere, a hand that makes the peace sign, a letter pressed
# into a ball, and a bar bent to a spring. Then it plays the letter backwards, and draws everything.
# All is written into out/demo.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
knead=${KNEAD:-knead}
out=$(dirname "$here")/out/demo
mkdir -p "$out"
for session in head peace letter spring; do cp "$here/$session.knead" "$out"; done
cd "$out"

"$knead" make sphere -n 60000 -o sphere.ply
"$knead" make hand -o hand.ply
"$knead" make letter-y -o letter-y.ply
"$knead" make box -o box.ply
"$knead" deform sphere.ply head.knead -q -o head.ply
"$knead" deform hand.ply peace.knead --report report.json -o peace.ply
"$knead" deform sphere.ply letter.knead -o letter.ply
"$knead" deform box.ply spring.knead -o spring.ply
"$knead" deform letter.ply letter.knead --inverse -q -o sphere_again.ply

# Draws a shape, seen from an azimuth and an elevation.
draw() { "$knead" render "$1.ply" --view "$2" --size 800x800 --cavity --occlusion -q -o "$1.jpg"; }
drawn=
if draw head 24,7 && draw peace 25,14 && draw letter 12,8 && draw spring 25,14; then
  drawn="  *.jpg              pictures of these four
"
else
  printf 'There are no pictures (see above); everything else was made.\n' >&2
fi

cat <<END

Written to $out:
  head.ply           a creature's head, sculpted from sphere.ply by head.knead
  peace.ply          the peace sign: hand.ply, posed by peace.knead
  letter.ply         a letter in a ball: sphere.ply and letter.knead
  spring.ply         a bar that is bent to a spring: box.ply and spring.knead
  sphere_again.ply   the ball again: letter.ply after the same session backwards
  report.json        of the hand: volume error, moved vertices, steps, seconds
$drawn
Try next, with a shape of your own (PLY, OBJ, STL, OFF, GLB or XYZ):
  $knead info SHAPE
  $knead bend SHAPE --angle 90 -o bent.stl
  $knead render SHAPE bent.stl -o picture.png
and change the numbers in spring.knead, a text file with a stroke in each line.
docs/session.md describes every tool, docs/command.md every option.
END
