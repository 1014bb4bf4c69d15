#!/usr/bin/env bash
# The front ends in other programs, built and tested:  plugins.sh blender | paraview
set -euo pipefail
# shellcheck source=tools/dev/build.sh
source "$(dirname "${BASH_SOURCE[0]}")/build.sh"

blender() {
  require_build
  require_render
  require python test || die "the add-on and its tests need the module of Python, which needs the packages above"
  compile release knead knead_python
  bindings/blender/build.sh build/release/python out/knead_blender.zip
  say "made out/knead_blender.zip; in Blender: Edit > Preferences > Add-ons > Install"
  have blender || require blender || die "the add-on is made and not tested, because there is no Blender"
  run_tests release -L '^knead_blender$'
}

# Prints which Qt the system's ParaView is built with.
qt_of_paraview() {
  if [[ $(apt-cache depends paraview 2>/dev/null) == *libqt6* ]]; then echo qt6; else echo qt5; fi
}

# The plugin is a project of its own, because only it needs ParaView; it takes the library as any program does that finds
# it installed.
paraview() {
  require_build
  require python paraview "paraview_$(qt_of_paraview)" || die "the plugin needs the packages above"
  compile release knead knead_python
  local options=()
  if have ccache; then options+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache); fi
  cmake --install build/release --component development --prefix "$root/build/release/installed" >/dev/null ||
    die "could not install the library for the plugin"
  options+=(-Dknead_ROOT="$root/build/release/installed")
  cmake -S bindings/paraview -B build/paraview -G Ninja -DCMAKE_BUILD_TYPE=Release -Wno-dev "${options[@]}" \
    --log-level=NOTICE ||
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
