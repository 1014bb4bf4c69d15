#!/usr/bin/env bash
# Makes wheels with zig's compiler, one for each Python whose headers are here:  wheels.sh [TARGET...]
# Targets: x86_64-linux-gnu.2.17 (default), aarch64-linux-gnu.2.17. KNEAD_PYTHONS names the programs of the Pythons; by
# default those of 3.11 to 3.14 on the path and of pyenv. The wheels lie in out/wheels; those that this machine can run
# are installed into a fresh environment, where they move points.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
targets=("${@:-x86_64-linux-gnu.2.17}")
venv=build/wheels/tools
zig=0.17.1
export CCACHE_COMPILERCHECK=string:zig-$zig # what ccache sees of the compiler is a script that never changes
say() { printf 'wheels: %s\n' "$*" >&2; }

tools() {
  [[ -x $venv/bin/python ]] || /usr/bin/python3 -m venv "$venv"
  "$venv/bin/pip" install --quiet ziglang=="$zig" pybind11==3.1.0 auditwheel twine || {
    say "the tools come from the Python index, which was not reached"
    exit 1
  }
  packages=$("$venv/bin/python" -c 'import sysconfig; print(sysconfig.get_paths()["purelib"])')
  export ZIG=$packages/ziglang/zig
}

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
    if [[ -n $found ]]; then printf '%s\n' "$found"; else say "no headers of Python $version are here: no wheel for it"; fi
  done
}
headers_of() { "$1" -c 'import sysconfig; print(sysconfig.get_paths()["include"])'; }
number_of() { "$1" -c 'import sys; print("%d%d" % sys.version_info[:2])'; }

# The licences of all that is compiled in.
licences() {
  local folder=build/wheels/licences library
  rm -rf "$folder" && mkdir -p "$folder"
  cp LICENSE "$folder/knead.txt"
  for library in libfmt-dev nlohmann-json3-dev libxsimd-dev libeigen3-dev; do
    cp "/usr/share/doc/$library/copyright" "$folder/$library.txt"
  done
  cp "$packages"/pybind11-*.dist-info/licenses/LICENSE "$folder/pybind11.txt"
  cp "$packages/ziglang/lib/libcxx/LICENSE.TXT" "$folder/libcxx.txt"
}

# The library is built once for a target; only the module is built again for each Python.
build() {
  local target=$1 python=$2 suffix=$3 launcher=()
  if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
  ZIG_TARGET=$target cmake -S . -B "build/wheels/$target" -G Ninja -DCMAKE_BUILD_TYPE=Release --log-level=NOTICE \
    -DCMAKE_TOOLCHAIN_FILE="$root/cmake/cross/zig.cmake" -DZIG_TARGET="$target" "${launcher[@]}" -DKNEAD_STD_THREADS=ON \
    -DKNEAD_STRICT=OFF -DKNEAD_BUILD_TESTS=OFF -DKNEAD_BUILD_BENCH=OFF -DKNEAD_BUILD_COMMAND=OFF \
    -DKNEAD_BUILD_EXAMPLES=OFF -DKNEAD_BUILD_GPU=OFF -DKNEAD_BUILD_RENDER=OFF -DKNEAD_BUILD_STUDIO=OFF \
    -DCMAKE_DISABLE_FIND_PACKAGE_draco=ON -DCMAKE_DISABLE_FIND_PACKAGE_meshoptimizer=ON \
    "-DKNEAD_PYTHON_HEADERS=$packages/pybind11/include;$(headers_of "$python")" "-DKNEAD_PYTHON_SUFFIX=$suffix"
  cmake --build "build/wheels/$target" --target knead_python
}

# Installs a wheel into a fresh environment and runs README's example on a shape that the library makes.
try() {
  local wheel=$1 python=$2 fresh
  fresh=$(mktemp -d)
  "$python" -m venv "$fresh/venv"
  "$fresh/venv/bin/pip" install --quiet "$wheel"
  (cd "$fresh" && venv/bin/python "$root/tools/packaging/try_wheel.py") || {
    say "$wheel failed"
    exit 1
  }
  rm -rf "$fresh"
}

tools
licences
mapfile -t found < <(pythons)
for target in "${targets[@]}"; do
  processor=${target%%-*}
  for python in "${found[@]}"; do
    number=$(number_of "$python")
    suffix=.cpython-$number-$processor-linux-gnu.so
    build "$target" "$python" "$suffix"
    wheel=$("$venv/bin/python" tools/packaging/make_wheel.py "$number" "manylinux_2_17_$processor" \
      "build/wheels/$target/python/knead/_knead$suffix" build/wheels/licences out/wheels)
    [[ $("$venv/bin/auditwheel" show "$wheel") == *'tag: "manylinux_2_17_'"$processor"* ]] || {
      say "$wheel needs a newer glibc than 2.17"
      exit 1
    }
    "$venv/bin/twine" check --strict "$wheel" >/dev/null || {
      say "twine refuses $wheel"
      exit 1
    }
    if [[ $processor == "$(uname -m)" ]]; then try "$wheel" "$python"; fi
    say "made $wheel"
  done
done
