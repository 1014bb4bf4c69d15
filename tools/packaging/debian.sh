#!/usr/bin/env bash
# Debian packages of the command, Studio and the library, in out/package:  debian.sh
set -euo pipefail
# shellcheck source=tools/dev/build.sh
source "$(dirname "${BASH_SOURCE[0]}")/../dev/build.sh"

require_programs
require package
compile release knead_programs knead-bench
rm -rf out/package
(cd build/release && cpack --config CPackConfig.cmake -B "$root/build/release/package" >package.log) ||
  die "no package was made; see build/release/package.log"
mkdir -p out/package
mv build/release/package/*.deb out/package
say "made $(echo out/package/*.deb); install with: apt-get install ./out/package/knead_*.deb"
