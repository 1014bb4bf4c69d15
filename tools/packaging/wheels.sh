#!/usr/bin/env bash
# Makes wheels with zig's compiler, one for each Python from 3.11 to 3.14:  wheels.sh [TARGET...]
# Targets are those of cross.sh (default: x86_64-linux-gnu.2.17). KNEAD_PYTHONS names the versions (default: "3.11 3.12 3.13
# 3.14"). The wheels lie in out/wheels. Each is installed into a fresh environment, where README's example runs: by this
# machine's Python, by ARM's under QEMU, by Windows' under Wine. Those for macOS are made and not run. This machine's Python also
# runs tests of the module in that environment, with the command KNEAD (default: build/release/knead) where that exists.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
# shellcheck source=tools/packaging/zig.sh
source tools/packaging/zig.sh
# shellcheck source=tools/packaging/pythons.sh
source tools/packaging/pythons.sh
targets=("${@:-x86_64-linux-gnu.2.17}")
read -ra versions <<<"${KNEAD_PYTHONS:-${python_versions[*]}}"
export WINEDEBUG=-all WINEPREFIX=$root/build/cross/wine
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

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
build() { # TARGET VERSION SUFFIX
  local headers library=
  headers=$(python_headers "$1" "$2") || return 2
  if [[ $1 == *-windows-* ]]; then library=$(python_library "$2") || return 2; fi
  zig_configure "$1" -DKNEAD_BUILD_PYTHON=ON "-DKNEAD_PYTHON_HEADERS=$zig_packages/pybind11/include;$headers" \
    "-DKNEAD_PYTHON_SUFFIX=$3" "-DKNEAD_PYTHON_LIBRARY=$library"
  cmake --build "build/cross/$1" --target knead_python
}

# Runs README's example with the packages of a folder, by a Python of another system.
run_elsewhere() { # TARGET VERSION FOLDER
  local python program system=$python_folder/3.13/linux-arm64 # of Debian, with libraries that others need
  program=$(python_there "$1" "$2")
  python=$python_folder/$2/$(python_system "$1")
  case $1 in
    *-windows-*)
      if [[ ! -d $WINEPREFIX ]]; then wineboot -i >/dev/null 2>&1; fi
      # The package has the program in another folder than its libraries and modules.
      (cd "$3" && PYTHONHOME=$python PYTHONPATH="$3;$python/lib" WINEPATH="$python;$python/lib" \
        wine "$program" "$root/tools/packaging/try_wheel.py" </dev/null 2>&1 | cat)
      ;;
    aarch64-*)
      if [[ $program == "$python"/usr/* ]]; then system=$python; fi
      (cd "$3" && PYTHONPATH=$3 qemu-aarch64-static -L "$system" -E "LD_LIBRARY_PATH=$python" "$program" \
        "$root/tools/packaging/try_wheel.py")
      ;;
  esac
}

# Runs quick tests of the module that an environment has.
run_tests() { # TARGET VERSION FOLDER_OF_PROGRAMS
  local knead=${KNEAD:-$root/build/release/knead} names=(animation arrays cells copies gesture pose skin) name report
  local files=()
  for name in "${names[@]}"; do files+=("$root/bindings/python/tests/test_$name.py"); done
  [[ -x $knead ]] || return 0
  "$3/pip" install --quiet --disable-pip-version-check pytest
  report=$(cd "$scratch" && KNEAD=$knead KNEAD_SOURCE=$root PYTHONDONTWRITEBYTECODE=1 "$3/python" -m pytest -q -p no:cacheprovider \
    "${files[@]}" 2>&1) || {
    printf '%s\n' "$report" >&2
    zig_fact "$1" "wheel, CPython $2" tests "failed"
    return 1
  }
  zig_fact "$1" "wheel, CPython $2" tests "$(tail -1 <<<"$report" | sed 's/ in .*//') (${names[*]})"
}

# Installs a wheel into a fresh environment and runs README's example on a sphere. Prints by what; nothing where this
# machine cannot run such a Python.
try() { # TARGET VERSION WHEEL
  local fresh python system=${1%%-*} numpy=numpy said
  fresh=$(mktemp -d -p "$scratch")
  if [[ $1 == "$(uname -m)"-linux-* ]]; then
    python=$(python_here "$2") || python=$python_folder/$2/linux-$(uname -m)/bin/python$2
    "$python" -m venv "$fresh/venv"
    "$fresh/venv/bin/pip" install --quiet --disable-pip-version-check "$3"
    (cd "$fresh" && venv/bin/python "$root/tools/packaging/try_wheel.py") >&2 || return
    echo "README's example in a fresh environment"
    run_tests "$1" "$2" "$fresh/venv/bin" || return
    return
  fi
  python_there "$1" "$2" >/dev/null || return 0
  local places=(--platform "manylinux2014_$system" --platform "manylinux_2_17_$system" --platform "manylinux_2_27_$system" --platform "manylinux_2_28_$system")
  if [[ $1 == *-windows-* ]]; then places=(--platform win_amd64) numpy=numpy==2.1.3; fi # newer ones need more than Wine 8 has
  "$zig_venv/bin/pip" install --quiet --disable-pip-version-check --target "$fresh" --only-binary :all: "${places[@]}" --python-version "$2" \
    "$3" "$numpy" || {
    zig_say "no numpy for Python $2 of $1 that runs here: $3 was not tried"
    return 0
  }
  said=$(run_elsewhere "$1" "$2" "$fresh") || true
  printf '%s\n' "$said" >&2
  [[ $said == *"in Python $2."* ]] || return 1
  if [[ $1 == *-windows-* ]]; then echo "README's example under Wine"; else echo "README's example under QEMU"; fi
}

check() { # TARGET PLATFORM WHEEL
  if [[ $1 == *-linux-* && $("$zig_venv/bin/auditwheel" show "$3") != *"tag: \"$2"* ]]; then
    zig_say "$3 needs a newer glibc than 2.17"
    exit 1
  fi
  if [[ $1 == *-macos ]]; then
    local found
    found=$("$zig_venv/bin/python" tools/packaging/mach.py "$(printf '%s\n' "build/cross/$1"/python/knead/_knead*-darwin.so | sed -n 1p)")
    zig_say "$found"
  fi
  "$zig_venv/bin/twine" check --strict "$3" >/dev/null || {
    zig_say "twine refuses $3"
    exit 1
  }
  [[ $(stat -c %s "$3") -lt 8000000 ]] || {
    zig_say "$3 has more than 8 MB"
    exit 1
  }
}

zig_tools pybind11==3.1.0 auditwheel twine
zig_licences build/cross/licences pybind11
python_fetch
failed=()
for target in "${targets[@]}"; do
  platform=$(platform_of "$target")
  for version in "${versions[@]}"; do
    number=${version/./}
    suffix=$(suffix_of "$target" "$number")
    artefact="wheel, CPython $version"
    if ! build "$target" "$version" "$suffix"; then
      zig_say "no wheel of Python $version for $target"
      failed+=("$target/$version")
      continue
    fi
    wheel=$("$zig_venv/bin/python" tools/packaging/make_wheel.py "$number" "$platform" \
      "build/cross/$target/python/knead/_knead$suffix" build/cross/licences out/wheels)
    check "$target" "$platform" "$wheel"
    zig_fact "$target" "$artefact" built "$(stat -c %s "$wheel" | numfmt --to=si)B"
    if [[ $target == *-macos ]]; then
      zig_fact "$target" "$artefact" started "not run by us"
    elif started=$(try "$target" "$version" "$wheel"); then
      if [[ -n $started ]]; then zig_fact "$target" "$artefact" started "$started"; fi
    else
      failed+=("$wheel")
    fi
    zig_say "made $wheel"
  done
done
[[ ${#failed[@]} -eq 0 ]] || {
  zig_say "failed: ${failed[*]}"
  exit 1
}
