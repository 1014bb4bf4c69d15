#!/usr/bin/env bash
# Whether every file that names the version of Knead names that of CMakeLists.txt:
#   version_test.sh [ROOT]       check the tree under ROOT (default: this repository)
#   version_test.sh --self-test  prove that a difference in each of the files is found
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# FILE, and a pattern of sed whose group is the version; the first line that has it counts.
readonly places=(
  'include/knead/knead.h|^#define KNEAD_VERSION "([0-9.]+)"$'
  'CITATION.cff|^version: ([0-9.]+)$'
  'CHANGELOG.md|^## \[([0-9.]+)\] - [0-9]{4}-[0-9]{2}-[0-9]{2}$'
  'bindings/web/npm/package.json|^ *"version": "([0-9.]+)",$'
  'tools/packaging/vcpkg/knead/vcpkg.json|^ *"version": "([0-9.]+)",$'
)
# Files that take it from CMakeLists.txt, and the text by which they do.
readonly takers=(
  'pyproject.toml|input = "CMakeLists.txt"'
  'bindings/blender/manifest.toml.in|version = "@VERSION@"'
)

check() { # ROOT
  local place file found version status=0
  version=$(sed -nE 's/^project\(knead VERSION ([0-9.]+).*/\1/p' "$1/CMakeLists.txt")
  for place in "${places[@]}"; do
    file=${place%%|*}
    found=$(sed -nE "s/${place#*|}/\\1/p" "$1/$file" | sed -n 1p)
    if [[ $found != "$version" ]]; then
      printf '%s has version %s, CMakeLists.txt has %s\n' "$file" "${found:-none}" "$version"
      status=1
    fi
  done
  for place in "${takers[@]}"; do
    file=${place%%|*}
    if ! grep -qF "${place#*|}" "$1/$file"; then
      printf '%s does not take its version from CMakeLists.txt\n' "$file"
      status=1
    fi
  done
  return $status
}

self_test() {
  local place file copy status=0
  copy=$(mktemp -d)
  # shellcheck disable=SC2064  # the folder of now
  trap "rm -rf '$copy'" EXIT
  for place in "${places[@]}" "${takers[@]}"; do
    rm -rf "${copy:?}"/*
    (cd "$here" && cp --parents CMakeLists.txt "${places[@]%%|*}" "${takers[@]%%|*}" "$copy")
    check "$copy" >/dev/null || return 1
    file=$copy/${place%%|*}
    sed -E -e 's/[0-9]+\.[0-9]+\.[0-9]+/9.9.9/' -e 's/CMakeLists|@VERSION@/x/' "$file" >"$copy/changed" && mv "$copy/changed" "$file"
    if check "$copy" >/dev/null; then
      printf 'a difference in %s was not found\n' "${place%%|*}"
      status=1
    fi
  done
  return $status
}

if [[ ${1:-} == --self-test ]]; then self_test; else check "${1:-$here}"; fi
