#!/usr/bin/env bash
# Builds the library, the command, Studio and tests of the library for another system, runs what can run here, and compares
# the command's outputs with those of this machine's command:
#   cross.sh [TARGET [PROGRAM...]]     (default: aarch64-linux-gnu.2.17; the tests of math, field, flow, io, session, history)
# PROGRAM may be `none`, for the command and Studio alone.
# Targets for Linux run by themselves or under QEMU, those for Windows under Wine, Studio on a display of its own (Xvfb);
# those for macOS are linked, and the commands in their headers are read. What was found is noted for the table in
# docs/packaging.md.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
# shellcheck source=tools/packaging/zig.sh
source tools/packaging/zig.sh
target=${1:-aarch64-linux-gnu.2.17}
shift || true
programs=("$@")
if [[ ${programs[0]:-} == none ]]; then programs=() # the command alone
elif [[ ${#programs[@]} -eq 0 ]]; then programs=(knead_{math,field,io,session,history,flow}_test)
fi
folder=build/cross/$target
suffix=
emulator=()
sets=scalar # of instructions, which can be tried here; empty: nothing of this target runs here
case $target in
  aarch64-*) sets+=" neon" ;;
  x86_64-*) for set in avx2 avx512; do if grep -q "$set" /proc/cpuinfo; then sets+=" $set"; fi; done ;;
esac
case $target in
  "$(uname -m)"-linux-*) ;;
  aarch64-linux-*) emulator=(qemu-aarch64-static -L "$root/$folder/system") ;;
  *-windows-*) suffix=.exe emulator=(wine) ;;
  *) sets= ;;
esac
export WINEDEBUG=-all WINEPREFIX=$root/build/cross/wine
ours=$(realpath "${KNEAD:-build/release/knead}")
[[ -z $sets || -x $ours ]] || {
  zig_say "to compare bits, build the command for this machine first: ./dev build"
  exit 1
}

# glibc of the target, of Debian's packages for another processor; nothing is installed.
guest_system() {
  [[ $target == aarch64-* && ! -e $folder/system/lib/ld-linux-aarch64.so.1 ]] || return 0
  mkdir -p "$folder/system"
  if [[ -e /usr/aarch64-linux-gnu/lib/ld-linux-aarch64.so.1 ]]; then
    ln -sfn /usr/aarch64-linux-gnu/lib "$folder/system/lib"
  else
    zig_say "no glibc for aarch64 is here; install libc6-arm64-cross"
    exit 1
  fi
}

# What takes minutes under QEMU, or has a limit of time that cannot be kept there. Tests of the same bits are not among it.
slow_under_qemu=(Grid.DetOf* Grid.PathLinesAre* Grid.GrowthMoves* Advect.ErrorStays* Advect.OneSegment* Advect.ForwardsThen*
  Advect.WithinABound* Turns.Agree* Turns.AreWell* Sum.PathLines* Sum.KeepsTheVolume* Pins.AreMet* Jacobians.OfAPoint*
  Masked.HoldsForEvery* Invariants.TheFlowMap* RemeshLimits.* ReplayRemeshed.What* ReplayRemeshed.AStroke*
  ReplayRemeshed.EveryFrame* SessionMask.Refuses* SessionMask.Remeshing* Derivatives.AreThose* Replay.ReportsAPathLine*
  WorkbenchPose.Follows* Workbench.RemeshesWhen* Deferred.RemeshingLooks*)

# Runs the tests of a program. Prints how many passed, and how many were left out; false if one failed.
run_test() {
  local program=$1 report=$folder/$1.txt status=0 filter='*' passed all
  [[ ${emulator[0]:-} != qemu-* ]] || filter=-$(IFS=: && echo "${slow_under_qemu[*]}")
  (cd "$folder/tests" && "${emulator[@]}" "./$program$suffix" --gtest_brief=1 "--gtest_filter=$filter") </dev/null >"$report" 2>&1 || status=$?
  passed=$(grep -aoE '^\[  PASSED  \] [0-9]+' "$report" | grep -oE '[0-9]+' || echo 0)
  all=$(cd "$folder/tests" && "${emulator[@]}" "./$program$suffix" --gtest_list_tests </dev/null 2>/dev/null | grep -ac '^  ')
  printf '%s of %s' "$passed" "$all"
  return $status
}

# Studio at a window, by the test of this machine's Studio; pictures of it lie in the target's folder.
run_studio() {
  local program=$root/$folder/knead-studio$suffix pictures=$root/$folder/pictures
  "${emulator[@]}" "$program" --version </dev/null 2>&1 | cat
  zig_fact "$target" studio started "${emulator[0]:-yes}"
  if [[ ${emulator[0]:-} == wine ]]; then # which calls the root of this machine Z:
    # shellcheck disable=SC2016  # expanded by that script
    printf '#!/bin/sh\nexport XDG_STATE_HOME="Z:$XDG_STATE_HOME" XDG_CONFIG_HOME="Z:$XDG_CONFIG_HOME"\nexec wine %q "$@"\n' \
      "$program" >"$folder/studio_under_wine.sh"
    chmod +x "$folder/studio_under_wine.sh"
    program=$root/$folder/studio_under_wine.sh
    export KNEAD_PICTURE_AT="4 23" # the frame that Wine leaves room for
    export KNEAD_NAME_FIELD="312 281"
    wineserver -k || true # Wine keeps the screen size of its first program, which had no display
  fi
  mkdir -p "$pictures"
  tests/studio/window_test.sh "$ours" "$program" "$pictures"
}

# shellcheck disable=SC2119  # no further packages
zig_tools
zig_configure "$target"
targets=(knead)
if zig_has "$target" knead-studio; then targets+=(knead-studio); fi
if [[ -n $sets ]]; then targets+=("${programs[@]}"); fi
cmake --build "$folder" --target "${targets[@]}"
zig_fact "$target" command built "$(stat -c %s "$folder/knead$suffix" | numfmt --to=si)B"
if [[ -z $sets ]]; then
  found=$("$zig_venv/bin/python" tools/packaging/mach.py "$folder/knead")
  zig_fact "$target" command started "not run by us; $found"
  exit 0
fi
guest_system
if [[ ${emulator[0]:-} == wine && ! -d $WINEPREFIX ]]; then wineboot -i >/dev/null 2>&1; fi
"${emulator[@]}" "$folder/knead$suffix" --version
zig_fact "$target" command started "${emulator[0]:-yes}"

failed=()
KNEAD_BITS_FOLDER=$(mktemp -d)
export KNEAD_BITS_FOLDER
if bits=$(tests/cross_bits.sh "$ours" "$sets" "${emulator[@]}" "$root/$folder/knead$suffix"); then
  rm -rf "$KNEAD_BITS_FOLDER"
  zig_fact "$target" command bits "$bits"
else
  zig_fact "$target" command bits "differ"
  failed+=(bits)
  zig_say "the outputs are in $KNEAD_BITS_FOLDER"
fi
printf '%s\n' "$bits"

if [[ ${emulator[0]:-} == wine ]]; then
  if tests/windows_test.sh "$folder/knead$suffix"; then
    zig_fact "$target" command tests "tests/windows_test.sh"
  else
    zig_fact "$target" command tests "tests/windows_test.sh failed"
    failed+=(windows_test.sh)
  fi
fi

if zig_has "$target" knead-studio; then
  zig_fact "$target" studio built "$(stat -c %s "$folder/knead-studio$suffix" | numfmt --to=si)B"
  if run_studio; then
    zig_fact "$target" studio tests "tests/studio/window_test.sh"
  else
    zig_fact "$target" studio tests "tests/studio/window_test.sh failed"
    failed+=(studio)
  fi
fi

passed=()
broken=()
for program in "${programs[@]}"; do
  zig_say "$program"
  name=${program#knead_}
  if report=$(run_test "$program"); then
    passed+=("${name%_test} $report")
  else
    broken+=("$program")
    grep -aE '^\[  FAILED  \]|Failure$' "$folder/$program.txt" >&2 || tail "$folder/$program.txt" >&2
  fi
  zig_say "$report"
done
if [[ ${#programs[@]} -gt 0 ]]; then
  printf -v report '%s, ' "${passed[@]}"
  zig_fact "$target" library tests "${broken[*]:+failed: ${broken[*]}; }passed: ${report%, }"
  zig_fact "$target" library built yes
fi
failed+=("${broken[@]}")
[[ ${#failed[@]} -eq 0 ]] || {
  zig_say "failed for $target: ${failed[*]}"
  exit 1
}
