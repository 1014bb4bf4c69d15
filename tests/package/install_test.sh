#!/usr/bin/env bash
# Tests what `cmake --install` puts under a prefix, and that it installs only what was built:
#   install_test.sh SOURCE_DIR BUILD_DIR WORK_DIR COMPILER
set -euo pipefail

source_dir=$1
build=$2
work=$3
compiler=$4
failures=0

fail() {
  echo "install_test: $*" >&2
  failures=$((failures + 1))
}
expect_file() { [[ -s $1 ]] || fail "not installed: ${1#"$work/"}"; }
expect_none() { [[ ! -e $1 ]] || fail "installed, but not built: ${1#"$work/"}"; }
have() { command -v "$1" >/dev/null || { echo "install_test: $1 is not installed; its check is skipped"; return 1; }; }

rm -rf "$work"
prefix=$work/prefix
cmake --install "$build" --prefix "$prefix" --component runtime >/dev/null
share=$prefix/share
bash_completion=$share/bash-completion/completions/knead
zsh_completion=$share/zsh/vendor-completions/_knead
expect_file "$prefix/bin/knead"
expect_file "$share/doc/knead/copyright"

if [[ -x $build/knead-bench ]]; then expect_file "$prefix/bin/knead-bench"; fi

# --- manual pages and completion follow --help ------------------------------------------------------------------------

knead=$prefix/bin/knead

# Prints the words before the description in the lines of a section of a help text: option names or subcommands.
names_in() {
  sed -n "/^$1:/,/^\$/p" | grep -oE '^  [^ ]+' | tr -d ' ' | tr ',' '\n'
}

# Prints what bash offers after the words given, of which the last one is incomplete.
offered() {
  bash -c 'source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _knead; printf "%s\n" "${COMPREPLY[@]}"' \
    bash "$bash_completion" "$@"
}

check_options() {
  local name words options manual
  words=$(offered knead "$@" -)
  options=$("$knead" "$@" --help | names_in Options)
  manual=$(gzip -dc "$page" | sed 's/\\-/-/g')
  [[ -n $options ]] || fail "no options in: knead $* --help"
  for name in $options; do
    grep -qxe "$name" <<<"$words" || fail "bash completion lacks: $* $name"
    grep -qF -e "${name}[" "$zsh_completion" || fail "zsh completion lacks: $* $name"
    grep -qF -e "$name" <<<"$manual" || fail "manual page lacks: $* $name"
  done
}

page=$share/man/man1/knead.1.gz
expect_file "$page"
check_options
subcommands=0
while read -r command; do
  subcommands=$((subcommands + 1))
  page=$share/man/man1/knead-$command.1.gz
  expect_file "$page"
  grep -qx "$command" <<<"$(offered knead "")" || fail "bash completion lacks: $command"
  grep -q "^    '$command:" "$zsh_completion" || fail "zsh completion lacks: $command"
  check_options "$command"
done < <("$knead" --help | names_in Subcommands)
[[ $subcommands -ge 9 ]] || fail "knead --help lists $subcommands subcommands"
[[ $(offered knead make sph) == sphere ]] || fail "bash completion lacks: make sphere"
if have zsh; then zsh -n "$zsh_completion" || fail "zsh refuses the completion"; fi
session_page=$(gzip -dc "$share/man/man5/knead-session.5.gz")
for words in tool mask width falloff radius; do
  grep -q "$words" <<<"$session_page" || fail "knead-session(5) lacks: $words"
done
if have man; then
  for page in "$share"/man/man[15]/*; do
    warnings=$(LC_ALL=C.UTF-8 MANROFFSEQ='' man --warnings -l "$page" 2>&1 >/dev/null)
    [[ -z $warnings ]] || fail "$(basename "$page"): $warnings"
  done
fi

# --- Studio -----------------------------------------------------------------------------------------------------------

desktop=$share/applications/knead-studio.desktop
mime=$share/mime/packages/knead.xml
if [[ -x $build/knead-studio ]]; then
  expect_file "$prefix/bin/knead-studio"
  expect_file "$desktop"
  expect_file "$mime"
  expect_file "$share/icons/hicolor/scalable/apps/knead-studio.svg"
  type=$(sed -n 's/.*<mime-type type="\([^"]*\)".*/\1/p' "$mime")
  grep -q "^MimeType=.*$type;" "$desktop" || fail "the desktop entry does not open $type"
  if have desktop-file-validate; then desktop-file-validate "$desktop" || fail "the desktop entry is invalid"; fi
  if have xmllint; then xmllint --noout "$mime" || fail "the MIME file is invalid"; fi
  if have update-mime-database; then
    update-mime-database "$share/mime" 2>/dev/null
    grep -q "$type:\*.knead" "$share/mime/globs2" || fail "*.knead is not of type $type"
  fi
fi

# --- builds of a part -------------------------------------------------------------------------------------------------

# A build folder that holds the command and the core library only.
part=$work/part
part_prefix=$work/part_prefix
cmake -S "$source_dir" -B "$part" -G Ninja --log-level=ERROR -DCMAKE_CXX_COMPILER="$compiler" -DCMAKE_BUILD_TYPE=Release \
  -DKNEAD_BUILD_TESTS=OFF -DKNEAD_BUILD_BENCH=OFF -DKNEAD_BUILD_EXAMPLES=OFF >/dev/null
cp "$build/knead" "$part/knead"
cp "$build/src/libknead.a" "$part/src/libknead.a"
cmake --install "$part" --prefix "$part_prefix" >/dev/null || fail "a build without Studio cannot be installed"
expect_file "$part_prefix/bin/knead"
expect_none "$part_prefix/bin/knead-bench"
expect_none "$part_prefix/bin/knead-studio"
expect_none "$part_prefix/share/applications"
mkdir "$work/user"
cat >"$work/user/CMakeLists.txt" <<'TEXT'
cmake_minimum_required(VERSION 3.25)
project(user LANGUAGES CXX)
find_package(knead REQUIRED)
if(NOT TARGET knead::core OR TARGET knead::gpu OR TARGET knead::render)
  message(FATAL_ERROR "find_package(knead) defines other targets than those that were built")
endif()
TEXT
cmake -S "$work/user" -B "$work/user/build" -G Ninja --log-level=ERROR -DCMAKE_CXX_COMPILER="$compiler" \
  -DCMAKE_PREFIX_PATH="$part_prefix" >/dev/null || fail "find_package(knead) fails for a build without GPU and renderer"

[[ $failures -eq 0 ]]
