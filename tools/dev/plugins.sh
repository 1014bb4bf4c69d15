#!/usr/bin/env bash
# The front ends in other programs, built and tested:  plugins.sh blender | paraview
set -euo pipefail
# shellcheck source=tools/dev/build.sh
source "$(dirname "${BASH_SOURCE[0]}")/build.sh"

blender() {
  require build
  require_render
  require python || die "the add-on needs the module of Python, which needs the packages above"
  compile release knead knead_python
  bindings/blender/build.sh build/release/python out/knead_blender.zip
  say "made out/knead_blender.zip; in Blender: Edit > Preferences > Add-ons > Install"
  if ! have blender; then
    say "Blender is not installed, so the add-on is not tested; on Debian: apt-get install blender xvfb"
  elif has_test_packages; then
    run_tests release -L '^knead_blender$'
  fi
}

# The plugin is a project of its own, because only it needs ParaView; it takes the library as any program does that finds
# it installed.
paraview() {
  require build
  require python paraview || die "the plugin needs the packages above"
  compile release knead knead_python
  local options=()
  if have ccache; then options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
  cmake --install build/release --component development --prefix "$root/build/release/installed" >/dev/null ||
    die "could not install the library for the plugin"
  options+=(-Dknead_ROOT="$root/build/release/installed")
  cmake -S bindings/paraview -B build/paraview -G Ninja -DCMAKE_BUILD_TYPE=Release "${options[@]}" --log-level=NOTICE ||
    die "could not configure the plugin"
  cmake --build build/paraview || die "the build of the plugin failed; the first 'error:' above says where"
  mkdir -p out/paraview
  cp build/paraview/lib/Knead/Knead.so out/paraview
  say "made out/paraview/Knead.so; in ParaView: Tools > Manage Plugins > Load New"
  bindings/paraview/tests/run.sh out/paraview/Knead.so || die "tests failed"
}

case ${1:-} in
  blender | paraview) "$@" ;;
  *) die "plugins.sh: blender or paraview, not '${1:-}'" ;;
esac
