#!/usr/bin/env bash
# Makes wheels with zig's compiler, one for each Python whose headers are here:  wheels.sh [TARGET...]
# Targets are those of cross.sh (default: x86_64-linux-gnu.2.17). KNEAD_PYTHONS names the programs of the Pythons; by
# default those of 3.11 to 3.14 on the path and of pyenv. KNEAD_CPYTHON names a folder with, for Windows, what its Pythons
# bring: 3.13/windows-x86_64/include and .../libs/python313.lib, and so on; without one, no wheel for Windows is made. The
# wheels lie in out/wheels; those that this machine can run are installed into a fresh environment, where they move points.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
# shellcheck source=tools/packaging/zig.sh
source tools/packaging/zig.sh
targets=("${@:-x86_64-linux-gnu.2.17}")

# Prints the programs of the Pythons with headers, one for each version.
pythons() {
  local version python found
  if [[ -n ${KNEAD_PYTHONS:-} ]]; then
    tr ' ' '\n' <<<"$KNEAD_PYTHONS"
    return
  fi
  for version in 3.11 3.12 3.13 3.14; do
    found=
    for python in "$HOME"/.pyenv/versions/"$version".*/bin/python3 /usr/bin/python"$version"; do
      if [[ -z $found && -x $python && -f $(headers_of "$python")/Python.h ]]; then found=$python; fi
    done
    if [[ -n $found ]]; then printf '%s\n' "$found"; else zig_say "no headers of Python $version are here: no wheel for it"; fi
  done
}
headers_of() { "$1" -c 'import sysconfig; print(sysconfig.get_paths()["include"])'; }
number_of() { "$1" -c 'import sys; print("%d%d" % sys.version_info[:2])'; }

# How wheels name a target, and how its modules of this Python are named.
platform_of() {
  case $1 in
    *-linux-gnu.2.17) echo "manylinux_2_17_${1%%-*}" ;;
    x86_64-windows-*) echo win_amd64 ;;
    aarch64-macos) echo macosx_11_0_arm64 ;;
    x86_64-macos) echo macosx_11_0_x86_64 ;;
  esac
}
suffix_of() { # TARGET NUMBER
  case $1 in
    *-linux-*) echo ".cpython-$2-${1%%-*}-linux-gnu.so" ;;
    *-windows-*) echo ".cp$2-win_amd64.pyd" ;;
    *-macos) echo ".cpython-$2-darwin.so" ;;
  esac
}

# The library is built once for a target; only the module is built again for each Python.
build() { # TARGET PYTHON SUFFIX
  local headers library=
  headers=$(headers_of "$2")
  if [[ $1 == *-windows-* ]]; then
    local version
    version=$("$2" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
    headers=${KNEAD_CPYTHON:-}/$version/windows-x86_64/include
    library=${KNEAD_CPYTHON:-}/$version/windows-x86_64/libs/python${version/./}.lib
    [[ -f $headers/Python.h && -f $library ]] || return 2
  fi
  zig_configure "$1" -DKNEAD_BUILD_PYTHON=ON "-DKNEAD_PYTHON_HEADERS=$zig_packages/pybind11/include;$headers" \
    "-DKNEAD_PYTHON_SUFFIX=$3" "-DKNEAD_PYTHON_LIBRARY=$library"
  cmake --build "build/cross/$1" --target knead_python
}

# Installs a wheel into a fresh environment and runs README's example on a shape that the library makes.
try() {
  local wheel=$1 python=$2 fresh
  fresh=$(mktemp -d)
  "$python" -m venv "$fresh/venv"
  "$fresh/venv/bin/pip" install --quiet "$wheel"
  (cd "$fresh" && venv/bin/python "$root/tools/packaging/try_wheel.py") || {
    zig_say "$wheel failed"
    exit 1
  }
  rm -rf "$fresh"
}

zig_tools pybind11==3.1.0 auditwheel twine
zig_licences build/cross/licences pybind11
mapfile -t found < <(pythons)
for target in "${targets[@]}"; do
  platform=$(platform_of "$target")
  for python in "${found[@]}"; do
    number=$(number_of "$python")
    suffix=$(suffix_of "$target" "$number")
    if ! build "$target" "$python" "$suffix"; then
      zig_say "no wheel of Python $number for $target: see KNEAD_CPYTHON in wheels.sh"
      continue
    fi
    wheel=$("$zig_venv/bin/python" tools/packaging/make_wheel.py "$number" "$platform" \
      "build/cross/$target/python/knead/_knead$suffix" build/cross/licences out/wheels)
    if [[ $target == *-linux-* ]]; then
      [[ $("$zig_venv/bin/auditwheel" show "$wheel") == *"tag: \"$platform"* ]] || {
        zig_say "$wheel needs a newer glibc than 2.17"
        exit 1
      }
    fi
    "$zig_venv/bin/twine" check --strict "$wheel" >/dev/null || {
      zig_say "twine refuses $wheel"
      exit 1
    }
    zig_fact "$target" "wheel, CPython ${number:0:1}.${number:1}" built "$(stat -c %s "$wheel" | numfmt --to=si)B"
    if [[ $target == "$(uname -m)"-linux-* ]]; then
      try "$wheel" "$python"
      zig_fact "$target" "wheel, CPython ${number:0:1}.${number:1}" started "README's example in a fresh environment"
    fi
    zig_say "made $wheel"
  done
done
