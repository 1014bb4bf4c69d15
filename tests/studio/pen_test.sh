#!/usr/bin/env bash
# The pressure of a pen, from the X server to the journal: Xorg without a screen or a tablet, whose driver `inputtest` is
# a pen. Paints softly and hard, with the pressure on the radius.
#   pen_test.sh KNEAD KNEAD_STUDIO PEN [FOLDER FOR PICTURES]
# Exit status 77 where Xorg or its drivers are missing, or where only root may start it.
set -euo pipefail

knead=$1
studio=$2
pen=$3
pictures=${4:-}
# shellcheck source=tests/studio/at_a_window.sh
source "$(dirname "$0")/at_a_window.sh"
need Xorg xdotool
modules=/usr/lib/xorg/modules
[[ -e $modules/drivers/dummy_drv.so && -e $modules/input/inputtest_drv.so ]] || {
  echo "Xorg's drivers dummy and inputtest are not installed: skipped"
  exit 77
}
[[ $(id -u) -eq 0 ]] || {
  echo "only root may start Xorg with a configuration of its own: skipped"
  exit 77
}

cat >"$work/xorg.conf" <<END
Section "ServerFlags"
  Option "AutoAddDevices" "false"
  Option "DontVTSwitch" "true"
EndSection
Section "InputDevice"
  Identifier "pen"
  Driver "inputtest"
  Option "SocketPath" "$work/pen.socket"
  Option "DeviceType" "PointerAbsolute"
  Option "PointerHasPressure" "true"
EndSection
Section "InputDevice"
  Identifier "keys"
  Driver "inputtest"
  Option "SocketPath" "$work/keys.socket"
  Option "DeviceType" "Keyboard"
EndSection
Section "Device"
  Identifier "card"
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
  Device "card"
  Monitor "monitor"
  DefaultDepth 24
  SubSection "Display"
    Modes "1280x800"
  EndSubSection
EndSection
Section "ServerLayout"
  Identifier "layout"
  Screen "screen"
  InputDevice "pen" "CorePointer"
  InputDevice "keys" "CoreKeyboard"
EndSection
END

start_server() {
  : >"$work/number"
  Xorg -noreset -sharevts -novtswitch -displayfd 9 -config "$work/xorg.conf" -logfile "$work/xorg.log" \
    9>"$work/number" >/dev/null 2>&1 &
  server=$!
  for ((i = 0; i < 300; ++i)); do
    DISPLAY=:$(<"$work/number")
    export DISPLAY
    if [[ $DISPLAY != : ]] && xdotool getmouselocation >/dev/null 2>&1; then return 0; fi
    kill -0 "$server" 2>/dev/null || break
    sleep 0.1
  done
  server=
  tail -3 "$work/xorg.log" 2>/dev/null || true
  echo "Xorg does not start here: skipped"
  exit 77
}

# paint Y PRESSURE: a line from left to right. One pen for all: the driver takes one connection.
paint() {
  local x
  echo "move 400 $1 $2" >&"$hand"
  sleep 0.4
  echo press >&"$hand"
  sleep 0.2
  for ((x = 410; x <= 560; x += 10)); do
    echo "move $x $1 $2" >&"$hand"
    sleep 0.04
  done
  sleep 0.2
  echo release >&"$hand"
}

# The radii of the strokes in the journal, each once.
radii() {
  sleep 1
  grep -o '"bump": *[0-9.e-]*' "$work"/state/knead/journals/*/session.knead | grep -o '[0-9.e-]*$' | sort -gu
}

mkdir -p "$work/config/knead"
echo '{"pen_pressure": "radius"}' >"$work/config/knead/studio.json"
start_server
exec {hand}> >("$pen" "$work/pen.socket")
"$knead" make sphere -n 10000 -o "$work/ball.ply" -q
start_studio "$work/ball.ply"
wait_for "the window" has_title 'ball.ply'
sleep 1
xdotool key 3 sleep 0.5

before=$(journal_lines)
paint 360 1
wait_for "the hard stroke" has_grown "$before"
hard=$(radii)
[[ $(wc -l <<<"$hard") -eq 1 ]] || die "a stroke of one pressure has the radii $hard"
before=$(journal_lines)
paint 440 0.5
wait_for "the soft stroke" has_grown "$before"
picture pen
soft=$(radii | sed -n 1p)
awk -v hard="$hard" -v soft="$soft" 'BEGIN { exit !(soft < 0.75 * hard && soft > 0.25 * hard) }' ||
  die "the radius is $hard with the whole pressure and $soft with half of it"
echo "passed: radius $hard with the whole pressure, $soft with half of it"
