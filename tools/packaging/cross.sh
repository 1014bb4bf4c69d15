#!/usr/bin/env bash
# Builds the library, the command and tests of the library for another system, runs what can run here, and compares the
# command's outputs with those of this machine's command:
#   cross.sh [TARGET [PROGRAM...]]     (default: aarch64-linux-gnu.2.17, and the tests of math, field, flow, io, session)
# PROGRAM may be `none`, for the command alone.
# Targets for Linux run by themselves or under QEMU, those for Windows under Wine; those for macOS are linked, and the
# commands in their headers are read. What was found is noted for the table in docs/packaging.md.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
# shellcheck source=tools/packaging/zig.sh
source tools/packaging/zig.sh
target=${1:-aarch64-linux-gnu.2.17}
shift || true
programs=("$@")
if [[ ${programs[0]:-} == none ]]; then programs=() # the command alone
elif [[ ${#programs[@]} -eq 0 ]]; then programs=(knead_{math,field,flow,io,session}_test)
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

# Prints the last line of a test program's report; false if a test failed.
run_test() {
  local program=$1 report=$folder/$1.txt status=0
  (cd "$folder/tests" && "${emulator[@]}" "./$program$suffix" --gtest_brief=1) </dev/null >"$report" 2>&1 || status=$?
  grep -aE '^\[  (PASSED|FAILED) ' "$report" | tr -d '\r' || true
  return $status
}

# shellcheck disable=SC2119  # no further packages
zig_tools
zig_configure "$target"
targets=(knead)
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

passed=0
failed=()
for program in "${programs[@]}"; do
  zig_say "$program"
  if report=$(run_test "$program"); then
    passed=$((passed + $(grep -aoE '[0-9]+ tests?\.?$' <<<"$report" | grep -oE '[0-9]+' | head -1)))
  else
    failed+=("$program")
    printf '%s\n' "$report" >&2
  fi
done
if [[ ${#programs[@]} -gt 0 ]]; then
  zig_fact "$target" library tests "${failed[*]:+failed: ${failed[*]}; }$passed passed (${programs[*]})"
  zig_fact "$target" library built yes
fi
if [[ ${emulator[0]:-} == wine ]]; then
  if tests/windows_test.sh "$folder/knead$suffix"; then
    zig_fact "$target" command tests "tests/windows_test.sh"
  else
    zig_fact "$target" command tests "tests/windows_test.sh failed"
    failed+=(windows_test.sh)
  fi
fi

KNEAD_BITS_FOLDER=$(mktemp -d)
export KNEAD_BITS_FOLDER
ours=${KNEAD:-build/release/knead}
[[ -x $ours ]] || {
  zig_say "to compare bits, build the command for this machine first: ./dev build"
  exit 1
}
if bits=$(tests/cross_bits.sh "$ours" "$sets" "${emulator[@]}" "$root/$folder/knead$suffix"); then
  rm -rf "$KNEAD_BITS_FOLDER"
  zig_fact "$target" command bits "$bits"
else
  zig_fact "$target" command bits "differ"
  failed+=(bits)
  zig_say "the outputs are in $KNEAD_BITS_FOLDER"
fi
printf '%s\n' "$bits"
[[ ${#failed[@]} -eq 0 ]] || {
  zig_say "failed for $target: ${failed[*]}"
  exit 1
}
