#!/usr/bin/env bash
# Tests what tools/dev/packages.sh asks each package manager for, with programs of their names that only note how they are called.
# shellcheck disable=SC2016 # what is in single quotes is for those programs
set -euo pipefail

source_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
failures=0
fail() {
  printf 'packages_test: %s\n' "$*" >&2
  failures=$((failures + 1))
}

# Writes a program that notes its arguments, finds no package installed, and knows all but draco and clang-14.
program() {
  printf '#!%s\necho "%s $*" >>%q\ncase "%s $*" in *draco* | *clang-14* | "rpm "* | "pacman -T"* | "apk info"* | "brew list"* | dpkg-query*) exit 1 ;; esac\n%s\n' \
    "$(command -v bash)" "$1" "$scratch/calls" "$1" "${2:-echo known}" >"$scratch/bin/$1"
  chmod +x "$scratch/bin/$1"
}

# Runs a call of packages.sh where only these programs and a few of every system are. Prints what it says.
with() { # CALL PROGRAM...
  local call=$1 name
  shift
  rm -rf "${scratch:?}"/*
  mkdir "$scratch/bin"
  : >"$scratch/calls"
  for name in bash cat env find grep mkdir sed sort; do ln -s "$(command -v "$name")" "$scratch/bin/$name"; done
  program sudo 'exec "$@"'
  for name in "$@"; do
    case $name in
      apt-cache) program apt-cache 'echo "Candidate: 1.0"' ;;
      cmake) program cmake 'echo cmake version 3.18.4' ;;
      c++) program c++ 'echo 10.2.1' ;;
      *) program "$name" ;;
    esac
  done
  (cd "$scratch" && PATH=$scratch/bin "$scratch/bin/bash" -c '
    say() { printf "%s\n" "$*" >&2; }
    die() { say "$@"; exit 1; }
    have() { command -v "$1" >/dev/null; }
    source "$1/tools/dev/packages.sh"; shift; eval "$1"' _ "$source_dir" "$call" 2>&1)
}

expect_call() { grep -qE -e "$1" "$scratch/calls" || fail "not called: $1; but: $(cat "$scratch/calls")"; }
expect_text() { [[ $1 == *"$2"* ]] || fail "it says '$1', not '$2'"; }

# A manager, its other programs, how it installs, and its name for fmt.
while read -r manager others install fmt; do
  # shellcheck disable=SC2086 # others: several or none
  text=$(with 'require build || echo lacking' "$manager" ${others//,/ }) || fail "$manager: $text"
  expect_call "^$manager .*${install//_/ }.* $fmt( |$)"
  expect_text "$text" lacking
  expect_text "$text" "no package for"
  ! grep -E "^$manager .*${install//_/ }.*draco" "$scratch/calls" || fail "$manager was asked to install what it lacks"
done <<'LIST'
apt-get dpkg-query,apt-cache install_-y libfmt-dev
dnf rpm install_-y fmt-devel
pacman true -S_--needed fmt
apk true add_-q fmt-dev
zypper rpm install_--no-recommends fmt-devel
brew true install_-q fmt
LIST

text=$(with 'require clang || echo lacking' apt-get dpkg-query apt-cache)
expect_call '^apt-get .*install .*(^| )clang( |$)' # Debian 13 has no clang-14
text=$(with 'require build && echo goes on' rpm)
expect_text "$text" libfmt-dev
expect_text "$text" "goes on"

# Debian 11 has these.
text=$(with check_tools cmake c++ ninja) && fail "old tools are not refused"
expect_text "$text" "g++ 12"
expect_text "$text" "3.18.4"
[[ $(wc -l <<<"$text") == 1 ]] || fail "more than a sentence: $text"

[[ $failures -eq 0 ]]
