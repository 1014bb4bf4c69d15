# shellcheck shell=bash
# What ./dev and the scripts beside this one share: messages, packages, and how a preset is configured, built and tested.
# Read by them with `source`; goes to the root of the source tree.

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root" || exit

say() { printf 'dev: %s\n' "$*" >&2; }
die() {
  say "$@"
  exit 1
}
have() { command -v "$1" >/dev/null; }

# shellcheck source=tools/dev/packages.sh
source "$root/tools/dev/packages.sh"

# Tests are part of a build as soon as their packages are installed; `demo` does not install them.
has_test_packages() {
  local wanted
  mapfile -t wanted < <(packages_of test)
  [[ $package_column -eq 0 || -z $(missing_packages "${wanted[@]}") ]]
}

configure() {
  local options=()
  if [[ $1 != fuzz && $1 != web* ]]; then
    if has_test_packages; then options+=(-DKNEAD_BUILD_TESTS=ON); else options+=(-DKNEAD_BUILD_TESTS=OFF); fi
  fi
  if have ccache; then options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
  options+=("-DKNEAD_STRICT=${KNEAD_STRICT:-OFF}" "-DKNEAD_FETCH=${KNEAD_FETCH:-OFF}")
  if [[ $1 == asan || $1 == fuzz ]] && ! have clang++-14; then options+=(-DCMAKE_CXX_COMPILER=clang++); fi
  if [[ $1 == web* ]]; then options+=(-DKNEAD_SOURCES="$root/build/sources"); fi
  if [[ -x /usr/bin/python3 ]]; then options+=(-DPython_EXECUTABLE=/usr/bin/python3); fi # Debian's, not a shim
  if [[ $1 != web* ]] && have mold; then options+=(-DCMAKE_EXE_LINKER_FLAGS=-fuse-ld=mold); fi
  cmake --preset "$@" "${options[@]}" --log-level=NOTICE ||
    die "could not configure; after a change of compiler delete build/$1 and try again"
}

# Builds a preset, or with more arguments some of its targets.
compile() {
  local preset=$1
  shift
  configure "$preset"
  cmake --build --preset "$preset" ${1:+--target "$@"} || die "the build failed; the first 'error:' above says where"
}

# Says once what the tests that were skipped would have needed.
say_what_is_missing() {
  local meshes reason
  meshes=$(sed -n 's/^KNEAD_TEST_MESHES:PATH=//p' "build/$1/CMakeCache.txt")
  [[ -d $meshes ]] || say "no folder $meshes: the tests with scans were skipped. The scans belong to others, so no command" \
    "fetches them; configure with -DKNEAD_TEST_MESHES=FOLDER where you have some"
  while read -r reason; do say "skipped: $reason"; done \
    < <(sed -nE 's/^skipped: |: skipped$//p' "build/$1/Testing/Temporary/LastTest.log" | sort -u)
}

run_tests() {
  local preset=$1
  shift
  ctest --test-dir "build/$preset" --output-on-failure --no-tests=error -j "$(nproc)" "$@" ||
    die "tests failed; run one alone with: ctest --test-dir build/$preset --output-on-failure -R NAME"
  say_what_is_missing "$preset"
}
