#!/usr/bin/env bash
# A pen with pressure at a true window: Xorg with a screen in memory, and a device that a socket moves. Paints with a
# light pen and with a firm one, and compares the strokes in the journal.
#   pen_test.sh KNEAD KNEAD_STUDIO [FOLDER FOR PICTURES]
# Exit status 77 where Xorg, its drivers `dummy` and `inputtest`, xdotool or python3 is missing.
set -euo pipefail

knead=$1
studio=$2
# shellcheck disable=SC2034  # for the functions
pictures=${3:-}
here=$(dirname "$0")
# shellcheck source=tests/studio/at_a_window.sh
source "$here/at_a_window.sh"
need Xorg xdotool python3

cat >"$work/xorg.conf" <<CONF
Section "ServerFlags"
  Option "AutoAddDevices" "false"
EndSection
Section "InputDevice"
  Identifier "pen"
  Driver "inputtest"
  Option "SocketPath" "$work/pen.socket"
  Option "DeviceType" "PointerAbsolute"
  Option "PointerHasPressure" "true"
EndSection
Section "Device"
  Identifier "memory"
  Driver "dummy"
  VideoRam 64000
EndSection
Section "Monitor"
  Identifier "monitor"
  HorizSync 5-1000
  VertRefresh 5-200
  Modeline "1280x800" 83.46 1280 1344 1480 1680 800 801 804 828
EndSection
Section "Screen"
  Identifier "screen"
  Device "memory"
  Monitor "monitor"
  DefaultDepth 24
  SubSection "Display"
    Depth 24
    Modes "1280x800"
    Virtual 1280 800
  EndSubSection
EndSection
Section "ServerLayout"
  Identifier "layout"
  Screen "screen"
  InputDevice "pen" "CorePointer"
EndSection
CONF

start_xorg() {
  : >"$work/number"
  Xorg -noreset -nolisten tcp -novtswitch -sharevts -displayfd 9 -config "$work/xorg.conf" -logfile "$work/xorg.log" \
    9>"$work/number" >/dev/null 2>&1 &
  server=$!
  for ((i = 0; i < 300; ++i)); do
    DISPLAY=:$(<"$work/number")
    export DISPLAY
    if [[ $DISPLAY != : && -S $work/pen.socket ]] && xdotool getmouselocation >/dev/null 2>&1; then return 0; fi
    kill -0 "$server" 2>/dev/null || break
    sleep 0.1
  done
  echo "Xorg with the drivers dummy and inputtest cannot be started here: skipped"
  grep '(EE)' "$work/xorg.log" || true
  exit 77
}

# paint PRESSURE: a line across the middle of the shape, from left to right.
paint() {
  local before
  before=$(journal_lines)
  {
    echo "move 0.38 $2 $1"
    echo "sleep 0.3"
    echo "press"
    echo "sleep 0.2"
    for ((k = 1; k <= 24; ++k)); do echo "move $(awk "BEGIN { print 0.38 + $k * 0.004 }") $2 $1" && echo "sleep 0.05"; done
    echo "release"
  } | python3 "$here/pen.py" "$work/pen.socket"
  wait_for "a painted stroke" has_grown "$before"
  sleep 1
}

# The dabs of the last line of the journal.
last_samples() { grep '"paint"' "$work"/state/knead/journals/*/session.knead | tail -n 1 | grep -o '"normal"' | wc -l; }
last_outer() {
  grep '"paint"' "$work"/state/knead/journals/*/session.knead | tail -n 1 | sed 's/.*"outer": \([0-9.e-]*\).*/\1/'
}
smaller() { awk "BEGIN { exit !($1 < $2) }"; }

start_xorg
"$knead" make sphere -n 10000 -o "$work/ball.ply" -q
start_studio "$work/ball.ply"
wait_for "the window" has_title 'ball.ply'
sleep 2
xdotool key 3 sleep 0.5
paint 1 0.45
firm=$(last_samples)
paint 0.25 0.55
light=$(last_samples)
picture depth
smaller $((2 * light)) "$firm" || die "a light pen sets $light dabs, a firm one $firm"
kill -9 "$window"
wait "$window" 2>/dev/null || true
rm -rf "$work/state"

mkdir -p "$work/config/knead"
echo '{"pen_pressure": "radius"}' >"$work/config/knead/studio.json"
start_studio "$work/ball.ply"
wait_for "the window" has_title 'ball.ply'
sleep 2
xdotool key 3 sleep 0.5
paint 1 0.45
firm=$(last_outer)
paint 0.25 0.55
light=$(last_outer)
picture radius
smaller "3.5 * $light" "$firm" || die "a light pen has radius $light, a firm one $firm"
echo "passed"
