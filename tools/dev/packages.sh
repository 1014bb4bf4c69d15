# shellcheck shell=bash
# Debian packages by purpose, and what installs them. Everything that ./dev ever installs stands here.
# Read by build.sh, which has say and have.

declare -A packages=(
  [build]="g++ cmake ninja-build libfmt-dev nlohmann-json3-dev libcli11-dev libtbb-dev libxsimd-dev libeigen3-dev
    libdraco-dev libmeshoptimizer-dev zlib1g-dev"
  [test]="libgtest-dev libboost-dev libcgal-dev"
  [render]="libepoxy-dev libegl-dev libegl1 libgl1-mesa-dri libstb-dev pkg-config"
  [studio]="libglfw3-dev libimgui-dev libx11-dev libxi-dev fonts-dejavu-core"
  [python]="python3-dev python3-numpy pybind11-dev"
  [python_test]="python3-pytest python3-hypothesis mypy python3-meshio python3-nbconvert python3-ipykernel
    python3-matplotlib"
  [wheel]="python3-venv"
  [studio_test]="xvfb xdotool imagemagick apitrace xserver-xorg-core xserver-xorg-video-dummy"
  [cross]="python3-venv libgtest-dev qemu-user-static libc6-arm64-cross wine wine64 libstb-dev fonts-dejavu-core dpkg-dev
    libegl-dev libx11-dev libxi-dev libxcursor-dev libxrandr-dev libxinerama-dev xvfb xdotool"
  [clang]="clang-14 libclang-rt-14-dev llvm-14"
  [lint]="clang-format-14 clang-tidy-14 shellcheck"
  [coverage]="gcovr"
  [docs]="doxygen graphviz"
  # What ParaView's CMake files ask for is not all among the dependencies of its package.
  [paraview]="paraview paraview-dev python3-paraview libopenmpi-dev openmpi-bin qtbase5-dev libqt5svg5-dev libutfcpp-dev
    libdouble-conversion-dev liblz4-dev liblzma-dev libpugixml-dev libexpat1-dev libfreetype-dev libgl2ps-dev libglew-dev
    libhdf5-dev libjpeg-dev libpng-dev libtiff-dev libnetcdf-dev libogg-dev libtheora-dev libjsoncpp-dev libxml2-dev
    libproj-dev libsqlite3-dev libcgns-dev libxt-dev protobuf-compiler libprotobuf-dev"
  [web]="libstb-dev fonts-dejavu-core fonttools dpkg-dev"
  [package]="dpkg-dev file"
  [package_test]="desktop-file-utils libxml2-utils shared-mime-info man-db zsh"
  [bench]="libbenchmark-dev libopenmesh-dev libassimp-dev libtinyobjloader-dev"
)

missing_packages() {
  local package
  for package in "$@"; do
    grep -qx installed <<<"$(dpkg-query -W -f '${db:Status-Status}\n' "$package" 2>/dev/null)" || printf '%s ' "$package"
  done
}

apt_install() {
  local as_root=()
  if [[ $EUID -ne 0 ]]; then
    have sudo || {
      say "no root rights; as root run: apt-get update && apt-get install $*"
      return 1
    }
    as_root=(sudo)
  fi
  local apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -o DPkg::Lock::Timeout=900)
  "${apt[@]}" update && "${apt[@]}" install -y --no-install-recommends "$@" >/dev/null
}

# Installs what is missing of the named groups; false where that failed.
require() {
  have dpkg-query || {
    say "not a Debian system: expecting the equivalents of these groups of packages to be installed: $*"
    return 0
  }
  local group wanted=() missing
  for group in "$@"; do
    read -rd "" -a group <<<"${packages[$group]}" || true # several lines
    wanted+=("${group[@]}")
  done
  read -ra missing <<<"$(missing_packages "${wanted[@]}")"
  [[ ${#missing[@]} -gt 0 ]] || return 0
  say "installing ${missing[*]}"
  apt_install "${missing[@]}" || {
    say "still missing, see above: ${missing[*]}"
    return 1
  }
}

require_render() { require render || say "building without the renderer, which is optional"; }
require_python() { require python || say "building without the module of Python, which is optional"; }

# What a user builds: library, command and Studio.
require_programs() {
  require build
  require_render
  require studio || say "building without the window of Studio, which is optional"
  require_python
}

setup() {
  require_programs
  require test
  require studio_test || say "going on without the tests of Studio's window"
  require python_test || say "going on without some tests of Python's module"
}
