# What tests of Studio at a true window share; to be sourced: Xvfb is the display, xdotool the hand. `studio` is the
# program, `pictures` a folder for pictures or empty. All places are those of Studio's picture; where the window's frame is
# in the way, KNEAD_PICTURE_AT="X Y" says where on the display that begins.
# shellcheck shell=bash

need() {
  local program
  for program in "$@"; do
    command -v "$program" >/dev/null || {
      echo "$program is not installed: skipped"
      exit 77
    }
  done
}

work=$(mktemp -d)
export HOME=$work XDG_STATE_HOME=$work/state XDG_CONFIG_HOME=$work/config LIBGL_ALWAYS_SOFTWARE=1
server=
window=
read -r left top <<<"${KNEAD_PICTURE_AT:-0 0}"

finish() {
  local status=$?
  [[ -z $window ]] || kill -9 "$window" 2>/dev/null || true
  [[ -z $server ]] || kill "$server" 2>/dev/null || true
  [[ $status -eq 0 ]] || { echo "failed; what Studio said:" && cat "$work/studio.log" 2>/dev/null; }
  rm -rf "$work"
}
trap finish EXIT

die() {
  echo "$(basename "$0"): $*" >&2
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
  Xvfb -noreset -displayfd 9 -screen 0 "$((1440 + 2 * left))x$((900 + 2 * top))x24" 9>"$work/number" >/dev/null 2>&1 &
  server=$!
  for ((i = 0; i < 600; ++i)); do
    DISPLAY=:$(<"$work/number")
    export DISPLAY
    if [[ $DISPLAY != : ]] && xdotool getmouselocation >/dev/null 2>&1; then return 0; fi
    sleep 0.1
  done
  die "Xvfb does not start"
}

# start_studio WORDS...: with the words of `under` before it.
under=()
start_studio() {
  # shellcheck disable=SC2154  # the caller's

  "${under[@]}" "$studio" "$@" >"$work/studio.log" 2>&1 &
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
  xdotool mousemove $(($1 + left)) $(($2 + top)) sleep 0.3 mousedown 1 sleep 0.1
  for ((k = 1; k <= 8; ++k)); do
    xdotool mousemove $(($1 + ($3 - $1) * k / 8 + left)) $(($2 + ($4 - $2) * k / 8 + top)) sleep 0.03
  done
  xdotool sleep 0.1 mouseup 1 sleep 0.3
}

click() { xdotool mousemove $(($1 + left)) $(($2 + top)) sleep 0.3 click 1 sleep 0.6; }

# press KEY: long enough to be seen in a picture, however slowly they follow each other.
press() { xdotool keydown "$1" sleep 0.5 keyup "$1"; }

# answer KEY FILE [desktop]: the file dialog that the key opens. `desktop`: under Wine it is that of Windows, whose field for
# the name is at KNEAD_NAME_FIELD="X Y"; without a window manager it has the keys only once it is clicked.
answer() {
  local name=$2
  xdotool key "$1" sleep 2
  if [[ ${3:-} == desktop && -n ${KNEAD_NAME_FIELD:-} ]]; then
    # shellcheck disable=SC2086  # two words
    click $KNEAD_NAME_FIELD
    xdotool key Home sleep 0.1 key shift+End
    name=Z:${name//\//\\}
  else
    xdotool key ctrl+a
  fi
  xdotool sleep 0.3 type --delay 60 "$name"
  xdotool sleep 1
  press Return
  wait_for "$2" test -s "$2"
}

# Leaves Studio where all is saved.
quit() {
  xdotool key ctrl+q
  for ((i = 0; i < 300; ++i)); do
    kill -0 "$window" 2>/dev/null || break
    sleep 0.1
  done
  wait "$window" || die "Studio ends with status $?"
  window=
}
