#!/usr/bin/env bash
# Builds targets from nothing and prints the processor time of their sources, by target and module.
#   bench/build_times.sh [TARGET...] [-- CMAKE OPTIONS]    targets: knead (default), all, ...
# Processor time hardly depends on what else runs on the machine; linking is not counted.
set -euo pipefail

# As compiler launcher: adds a line "SECONDS OUTPUT" to the log.
if [[ ${1:-} == --compile ]]; then
  log=$2
  shift 2
  output=
  for ((i = 1; i < $#; ++i)); do
    if [[ ${!i} == -o ]]; then
      next=$((i + 1))
      output=${!next}
    fi
  done
  exec 3>&2
  TIMEFORMAT="%U %S $output"
  { time "$@" 2>&3; } 2>>"$log"
  exit
fi

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
targets=()
while [[ $# -gt 0 && $1 != -- ]]; do
  targets+=("$1")
  shift
done
if [[ $# -gt 0 ]]; then shift; fi
build=$(mktemp -d)
trap 'rm -rf "$build"' EXIT
launcher="bash;$root/bench/build_times.sh;--compile;$build/times"
cmake -G Ninja -S "$root" -B "$build" -DCMAKE_BUILD_TYPE=Release \
  -DCMAKE_CXX_COMPILER_LAUNCHER="$launcher" --log-level=WARNING "$@" >/dev/null
cmake --build "$build" --target "${targets[@]:-knead}" >"$build/output" || {
  tail -n 20 "$build/output" >&2
  exit 1
}

# src/CMakeFiles/knead_core.dir/io/json.cpp.o is "knead_core io".
sort -k 3 "$build/times" | awk '
  {
    name = $3
    sub(/^.*CMakeFiles\//, "", name)
    split(name, part, "/")
    target = part[1]
    sub(/\.dir$/, "", target)
    if (target == "knead_core") target = target " " part[2]
    ++sources[target]
    seconds[target] += $1 + $2
    total += $1 + $2
  }
  END {
    for (target in sources) printf "%-24s %4d sources %7.1f s\n", target, sources[target], seconds[target]
    printf "%-24s %4d sources %7.1f s\n", "~ all", NR, total
  }' | sort
