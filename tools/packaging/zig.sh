# shellcheck shell=bash
# What the scripts for other systems share: zig from the Python index, and how a target is configured. Read with `source`
# by scripts that have gone to the root of the source tree. Every target has one folder, build/cross/TARGET.

# shellcheck source=tools/dev/sources.sh
source tools/dev/sources.sh
zig_version=0.17.1
zig_venv=build/cross/tools
zig_targets=(x86_64-linux-gnu.2.17 aarch64-linux-gnu.2.17 x86_64-windows-gnu aarch64-macos x86_64-macos)
export CCACHE_COMPILERCHECK=string:zig-$zig_version # what ccache sees of the compiler is a script that never changes
zig_say() { printf '%s: %s\n' "$(basename "$0" .sh)" "$*" >&2; }

# Installs zig and further packages of the Python index into an environment of their own:  zig_tools [PACKAGE...]
zig_tools() {
  [[ -x $zig_venv/bin/python ]] || /usr/bin/python3 -m venv "$zig_venv"
  "$zig_venv/bin/pip" install --quiet --disable-pip-version-check ziglang=="$zig_version" "$@" || {
    zig_say "the tools come from the Python index, which was not reached"
    exit 1
  }
  zig_packages=$("$zig_venv/bin/python" -c 'import sysconfig; print(sysconfig.get_paths()["purelib"])')
  export ZIG=$PWD/$zig_packages/ziglang/zig
  if [[ $zig_packages == /* ]]; then export ZIG=$zig_packages/ziglang/zig; fi
}

# zig_configure TARGET [OPTION OF CMAKE...]: the library, the command and the tests of the library.
zig_configure() {
  local target=$1 options=()
  shift
  [[ " ${zig_targets[*]} " == *" $target "* ]] || {
    zig_say "no target '$target'; say one of ${zig_targets[*]}"
    exit 2
  }
  if command -v ccache >/dev/null; then options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
  if [[ $target != *-macos ]]; then
    fetch_sources imgui glfw3 libepoxy || zig_say "without renderer and Studio: their sources were not reached; see build/sources/log"
    options+=("-DKNEAD_SOURCES=$PWD/build/sources")
  fi
  if [[ $target != *-macos && -f /usr/src/googletest/CMakeLists.txt ]]; then options+=(-DKNEAD_BUILD_TESTS=ON); else options+=(-DKNEAD_BUILD_TESTS=OFF); fi
  ZIG_TARGET=$target cmake -S . -B "build/cross/$target" -G Ninja -DCMAKE_BUILD_TYPE=Release --log-level=NOTICE \
    -DCMAKE_TOOLCHAIN_FILE="$PWD/cmake/cross/zig.cmake" -DZIG_TARGET="$target" -DKNEAD_STD_THREADS=ON \
    -DKNEAD_STRICT=OFF -DKNEAD_UNITY=ON -DKNEAD_INSTALL=OFF -DKNEAD_BUILD_BENCH=OFF -DKNEAD_BUILD_EXAMPLES=OFF -DKNEAD_BUILD_GPU=ON \
    -DKNEAD_BUILD_RENDER=ON -DKNEAD_BUILD_STUDIO=ON -DKNEAD_BUILD_PYTHON=OFF -DCMAKE_DISABLE_FIND_PACKAGE_draco=ON \
    -DCMAKE_DISABLE_FIND_PACKAGE_meshoptimizer=ON -DCMAKE_DISABLE_FIND_PACKAGE_ZLIB=ON \
    -DCMAKE_DISABLE_FIND_PACKAGE_Freetype=ON "${options[@]}" "$@"
}

# Whether a configured target of zig builds a program:  zig_has TARGET PROGRAM
zig_has() { ninja -C "build/cross/$1" -t query "$2" >/dev/null 2>&1; }

# The last commit that changed what is built; with a + if something was changed since.
zig_sources() {
  local of=(CMakeLists.txt cmake include src apps bindings)
  printf '%s%s\n' "$(git log -1 --format=%h --abbrev=8 -- "${of[@]}")" "$([[ -z $(git status --porcelain -- "${of[@]}") ]] || echo +)"
}

# Notes what was found about an artefact, for the table:  zig_fact PLATFORM ARTEFACT built|started|tests|bits TEXT
# What was found of earlier sources goes.
zig_fact() {
  local folder=build/cross/facts/$1/$2 now
  now=$(zig_sources)
  if [[ ! -f $folder/sources || $(<"$folder/sources") != "$now" ]]; then rm -rf "$folder"; fi
  mkdir -p "$folder"
  printf '%s\n' "$4" >"$folder/$3"
  printf '%s\n' "$now" >"$folder/sources"
  zig_say "$1, $2, $3: $4"
}

# Puts the licences of all that is compiled in into a folder:  zig_licences FOLDER [pybind11]
zig_licences() {
  local library
  rm -rf "$1" && mkdir -p "$1"
  cp LICENSE "$1/knead.txt"
  for library in libfmt-dev nlohmann-json3-dev libxsimd-dev libeigen3-dev; do
    cp "/usr/share/doc/$library/copyright" "$1/$library.txt"
  done
  cp "$zig_packages/ziglang/lib/libcxx/LICENSE.TXT" "$1/libcxx.txt"
  if [[ ${2:-} == pybind11 ]]; then
    cp "$zig_packages"/pybind11-*.dist-info/licenses/LICENSE "$1/pybind11.txt"
  else
    cp /usr/share/doc/libcli11-dev/copyright "$1/libcli11-dev.txt"
    cp /usr/share/doc/fonts-dejavu-core/copyright "$1/fonts-dejavu-core.txt"
    cp build/sources/imgui/LICENSE.txt "$1/imgui.txt"
    cp build/sources/glfw3/LICENSE.md "$1/glfw3.txt"
  fi
  cp build/sources/libepoxy/COPYING "$1/libepoxy.txt"
  cp /usr/share/doc/libstb-dev/copyright "$1/libstb-dev.txt"
  find "$zig_packages/ziglang/lib/libc/mingw" -maxdepth 1 -iname 'COPYING*' -exec cp {} "$1/mingw-w64.txt" \;
}
