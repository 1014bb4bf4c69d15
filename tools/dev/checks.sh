#!/usr/bin/env bash
# Checks and measurements that take from minutes to hours:  checks.sh COMMAND [ARGS], as ./dev help says:
# sanitize, fuzz, soak, coverage, bench
set -euo pipefail
# shellcheck source=tools/dev/build.sh
source "$(dirname "${BASH_SOURCE[0]}")/build.sh"

sanitize() {
  local kind=${1:-asan}
  [[ $kind == asan || $kind == tsan ]] || die "sanitize: asan or tsan, not '$kind'"
  require clang
  setup
  shift || true
  compile "$kind" "$@"
  local chosen=()
  if [[ $# -gt 0 ]]; then chosen=(-L "^($(IFS='|' && echo "$*"))\$"); fi
  run_tests "$kind" "${chosen[@]}" -LE slow # these take minutes each under a sanitizer; others run the same code on less
}

fuzz() {
  local seconds=${1:-60} fuzzer found known
  require_programs
  require clang
  compile fuzz
  for fuzzer in build/fuzz/fuzz/fuzz_*; do
    [[ -f $fuzzer && -x $fuzzer ]] || die "no fuzzer was built; see fuzz/CMakeLists.txt"
    found=build/fuzz/corpus/$(basename "$fuzzer")
    known=fuzz/corpus/$(basename "$fuzzer")
    [[ -d $known ]] || die "$known is not there"
    mkdir -p "$found"
    say "$fuzzer for $seconds s"
    "$fuzzer" -timeout=10 -rss_limit_mb=2048 -print_final_stats=1 -verbosity=0 -print_funcs=0 \
      -artifact_prefix="$found-" -max_total_time="$seconds" "$found" "$known" ||
      die "a crash was found; repeat it with: $fuzzer $found-..."
  done
}

soak() {
  [[ ${1:-} =~ ^[0-9]+$ ]] || die "soak: a number of minutes, not '${1:-}'"
  setup
  compile release knead knead_soak
  nice build/release/tests/knead_soak "$root/build/release/knead" "$((60 * $1))s" "${2:-$RANDOM}" 0 ${3:+"$3"}
}

coverage() {
  setup
  require coverage
  compile coverage
  run_tests coverage
  mkdir -p build/coverage/html
  gcovr --root . --filter src/ --filter apps/ --exclude '.*_test\.cpp' --exclude-unreachable-branches --print-summary \
    --html-details build/coverage/html/index.html build/coverage
  say "line by line: build/coverage/html/index.html"
}

bench() {
  require_programs
  local program name=${1:-}
  if [[ $# -gt 0 ]]; then shift; fi
  if [[ $name == waits ]]; then
    require test
    compile release knead knead-studio remesh_survey
    python3 bench/waits.py "$@"
    return
  fi
  require bench
  compile release knead knead_benchmarks
  for program in build/release/bench/${name:-*}_bench; do
    [[ -x $program ]] || die "no such benchmark was built: $program; see bench/CMakeLists.txt"
    "$program" "$@"
  done
}

case ${1:-} in
  sanitize | fuzz | soak | coverage | bench) "$@" ;;
  *) die "checks.sh: sanitize, fuzz, soak, coverage or bench, not '${1:-}'" ;;
esac
