#!/usr/bin/env bash
# What Windows does differently and the command must not show, under Wine:  windows_test.sh KNEAD.EXE
# shellcheck disable=SC2317  # the tests are called by their names
set -euo pipefail

knead=$(realpath "$1")
export WINEDEBUG=-all
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cd "$scratch"
failed=0
check() { # WHAT COMMAND...
  local what=$1
  shift
  if "$@"; then printf 'ok: %s\n' "$what"; else
    printf 'FAILED: %s\n' "$what"
    failed=1
  fi
}
run() { wine "$knead" "$@" </dev/null; }

run make hand -n 4000 -q -o hand.ply
cat >session.knead <<'SESSION'
{"knead": 1}
{"tool": "implicit", "path": [[0, 0.9, 0], [0, 1.1, 0]], "inner": 0.1, "outer": 0.5}
SESSION
run deform hand.ply session.knead -q -o bent.ply

# A binary file holds \n without \r, and \x1a, which ends a text.
piped() { wine "$knead" deform - session.knead --format ply -q -o - <hand.ply >piped.ply && cmp piped.ply bent.ply; }
check "pipes pass every byte" piped

umlauts() {
  mkdir -p "Größe 形" && cp hand.ply "Größe 形/händ.ply" &&
    run deform "Größe 形/händ.ply" session.knead -q -o "Größe 形/gebögen.ply" && cmp bent.ply "Größe 形/gebögen.ply"
}
check "names of files are UTF-8" umlauts

message() { ! run info "fehlt ä.ply" 2>message.txt && grep -q "fehlt ä.ply" message.txt; }
check "messages are UTF-8" message

itself() { cp hand.ply own.ply && run deform own.ply session.knead -q -o own.ply && cmp own.ply bent.ply; }
check "a file replaces itself" itself

stack() {
  python3 - "$knead" <<'PYTHON'
import struct, sys
data = open(sys.argv[1], "rb").read(4096)
header = struct.unpack_from("<I", data, 0x3C)[0]
sys.exit(struct.unpack_from("<Q", data, header + 24 + 72)[0] < 8 << 20)
PYTHON
}
check "stacks have 8 MiB" stack

# Ctrl-C during a deformation leaves no part of a file. The session has 100 strokes, so that it does not end first.
interrupted() {
  local status=0
  run make sphere -n 400000 -q -o large.ply
  cp large.ply target.ply
  {
    echo '{"knead": 1}'
    for _ in {1..100}; do echo '{"tool": "implicit", "path": [[0, 0.9, 0], [0, 1.1, 0]], "inner": 0.1, "outer": 5}'; done
  } >long.knead
  timeout -s INT 2 wine "$knead" deform large.ply long.knead --tolerance 1e-12 --precision double -q -o target.ply \
    </dev/null >/dev/null 2>message.txt || status=$?
  [[ $status -ne 0 ]] && grep -q interrupted message.txt && cmp target.ply large.ply && [[ -z $(find . -name '.knead-*') ]]
}
check "an interruption leaves the old file" interrupted

readonly_folder() { ! run make sphere -q -o missing/sphere.ply 2>message.txt && grep -q "does not exist" message.txt; }
check "a folder that is missing is said to be missing" readonly_folder

wrong_word() {
  local status=0
  run nonsense 2>message.txt || status=$?
  [[ $status -eq 2 ]] && grep -q "no command 'nonsense'" message.txt
}
check "exit codes are passed on" wrong_word
exit $failed
