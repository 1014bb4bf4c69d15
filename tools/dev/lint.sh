#!/usr/bin/env bash
# What ./dev lint and ./dev format do:  lint.sh lint [--all] | format | quick
# quick is what every ./dev test does first: it builds nothing and takes seconds.
set -euo pipefail
# shellcheck source=tools/dev/build.sh
source "$(dirname "${BASH_SOURCE[0]}")/build.sh"

# Prints the project's own files whose names match one of the patterns, each ended by a zero byte.
own_files() {
  local names=() pattern
  for pattern in "$@"; do names+=(-o -name "$pattern"); done
  find . \( -path './build*' -o -path './out' -o -path './.git' \) -prune -o -type f \( "${names[@]:1}" \) -print0
}

check_format() {
  have clang-format-14 || { # other versions format differently
    say "formatting is not checked: this system has no clang-format-14"
    return 0
  }
  own_files '*.h' '*.cpp' | xargs -0 clang-format-14 --dry-run -Werror ||
    die "not formatted as .clang-format says; run: ./dev format"
}

check_scripts() {
  local found
  own_files '*.sh' | xargs -0 shellcheck -x dev .ci/run || die "shellcheck found the above"
  # Both stop reading early; what writes into the pipe may then end with SIGPIPE, which pipefail reports now and then.
  found=$(own_files '*.sh' dev run | xargs -0 grep -nE '\| *(grep +-[a-zA-Z]*q|[h]ead )') || return 0
  die "a pipe that ends before its source (use <<< or sed -n 1p): $found"
}

# The web's standard library, libc++ 13, lacks these; vec.h has bit_cast, io/numbers.h numbers in text. From version 12 on,
# fmt/format.h alone has no fmt::join.
check_portable() {
  local found
  found=$(grep -rlF 'fmt::join(' src include apps bindings --include='*.h' --include='*.cpp' | xargs grep -LF '<fmt/ranges.h>') || true
  [[ -z $found ]] || die "these use fmt::join and must include <fmt/ranges.h>: $found"
  found=$(grep -rnE 'std::(ranges|views)::|std::(bit_cast|atomic_ref|make_unique_for_overwrite)\b' src include apps/studio --include='*.h' --include='*.cpp' \
    --exclude='*_test.cpp') || return 0
  die "emscripten cannot compile these: $found"
}

quick_checks() {
  check_portable
  check_format
  if have shellcheck; then check_scripts; fi
}

check_includes() {
  tests/include_table_test.sh || die "an include breaks the table of modules"
}

# Prints the commit that changes are measured from: where the main branch was left, or on it the commit before.
lint_base() {
  local branch base
  for branch in origin/main main; do
    base=$(git merge-base HEAD "$branch" 2>/dev/null) || continue
    [[ $base != $(git rev-parse HEAD) ]] || base=$(git rev-parse --verify --quiet HEAD~1) || return 1
    printf '%s\n' "$base"
    return
  done
  return 1
}

# Prints what differs from a commit: committed, uncommitted and new files.
changed_files() {
  git diff --name-only --diff-filter=d "$1"
  git ls-files --others --exclude-standard
}

# Prints a source that reads a header: its own where there is one, else the first that includes it.
source_of() {
  local own=${1%.h}.cpp
  if [[ -f $own ]]; then
    printf '%s\n' "$own"
  else
    grep -rlF --include='*.cpp' --exclude='*_test.cpp' -e "/${1##*/}\"" -e "\"${1##*/}\"" src apps | sort | sed 1q
  fi
}

# Prints the sources to analyse: programs and library; the macros of GoogleTest would drown the rest.
sources_to_lint() {
  local base file
  if [[ ${1:-} == --all ]]; then
    find src apps -name '*.cpp'
  elif base=$(lint_base); then
    changed_files "$base" | while read -r file; do
      case $file in
        src/*.cpp | apps/*.cpp) printf '%s\n' "$file" ;;
        include/*.h | src/*.h | apps/*.h) source_of "$file" ;;
      esac
    done
  else
    say "no commit to compare with: static analysis is skipped; ./dev lint --all analyses everything"
  fi | grep -v '_test\.cpp$' | sort -u
}

# Passes on the sources that this machine builds: no kernels of other processors, no substitutes for missing libraries.
built_here() {
  local source
  while read -r source; do
    if grep -qF "\"file\": \"$root/$source\"" build/debug/compile_commands.json; then printf '%s\n' "$source"; fi
  done
}

# Analyses one source, unless the time is over. Run by xargs in a shell of its own.
tidy_one() {
  if [[ $(date +%s) -lt $KNEAD_LINT_END ]]; then
    "$(command -v clang-tidy-14 || command -v clang-tidy)" --quiet -p build/debug "$1"
  else
    printf 'dev: no time left for %s\n' "$1" >&2
  fi
}

check_tidy() {
  local sources
  configure debug
  mapfile -t sources < <(sources_to_lint "$@" | built_here)
  [[ ${#sources[@]} -gt 0 ]] || return 0
  say "static analysis of ${#sources[@]} sources"
  export -f tidy_one
  export KNEAD_LINT_END=$(($(date +%s) + 60 * ${KNEAD_LINT_MINUTES:-600}))
  # shellcheck disable=SC2016  # for the shell that xargs starts
  printf '%s\0' "${sources[@]}" | xargs -0 -P "$(nproc)" -I '{}' bash -c 'tidy_one "$1"' _ '{}' ||
    die "clang-tidy found the above; .clang-tidy says what is checked"
}

lint() {
  export KNEAD_STRICT=ON
  [[ $# -eq 0 || "$*" == --all ]] || die "lint: nothing or --all, not '$*'"
  require_programs
  require lint || say "going on without what this system lacks"
  local check failed=()
  for check in check_format check_scripts check_includes check_portable "check_tidy $*"; do
    # shellcheck disable=SC2086  # the check and its argument
    ($check) || failed+=("${check%% *}")
  done
  [[ ${#failed[@]} -eq 0 ]] || die "failed: ${failed[*]}"
}

format() {
  require lint || say "going on without what this system lacks"
  have clang-format-14 || die "the format is that of clang-format-14, which this system lacks"
  own_files '*.h' '*.cpp' | xargs -0 clang-format-14 -i
}

case ${1:-} in
  lint | format) "$@" ;;
  quick) quick_checks ;;
  *) die "lint.sh: lint, format or quick, not '${1:-}'" ;;
esac
