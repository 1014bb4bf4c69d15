#!/usr/bin/env bash
# Studio's page in out/web and the module of JavaScript in out/web/npm:  web.sh [serve [PORT]]
# Tests them in node and Chromium; serve shows out/web at localhost.
set -euo pipefail
# shellcheck source=tools/dev/build.sh
source "$(dirname "${BASH_SOURCE[0]}")/build.sh"
# shellcheck source=tools/dev/sources.sh
source tools/dev/sources.sh

# What the tests take from the npm registry; false where it is not reached.
web_test_packages() {
  cp bindings/web/package.json build/web
  npm install --prefix build/web --no-audit --no-fund --loglevel=error >build/web/npm.log 2>&1 || return 1
  ln -sfn ../npm build/web/node_modules/knead
}

# Puts the page together: what is served, and the list of it that is kept for later.
make_site() {
  local site=build/web/site files
  rm -rf "$site" && mkdir -p "$site"
  cp bindings/web/page/* bindings/web/npm/fused.js build/web/page/knead_studio.{mjs,wasm} LICENSE "$site"
  cp build/web_threads/page/knead_studio_threads.* "$site"
  cp share/knead-studio.svg "$site/icon.svg"
  files=$(cd "$site" && printf "'%s', " knead_studio_threads.*) # some versions of emscripten write a worker.js, others do not
  sed -i -e "s|KNEAD_THREADED|${files%, }|" "$site/studio.js"
  files=$(cd "$site" && printf "'%s', " ./ index.html ./*.css ./*.js ./*.mjs ./*.wasm ./*.svg ./*.webmanifest | sed "s/'[^']*sw.js', //; s/'[^']*knead_studio[^']*', //g")
  sed -i -e "s|KNEAD_FILES|${files%, }|" \
    -e "s|KNEAD_VERSION_OF_FILES|$(cat "$site"/*.* | sha256sum | cut -c1-16)|" "$site/sw.js"
}

test_web() {
  have npm || require npm || die "made and not tested: the tests need npm"
  require web_test || say "testing without Chromium"
  web_test_packages || die "made and not tested: the npm registry was not reached; see build/web/npm.log"
  rm -rf build/web/tests build/web/bench
  cp -r bindings/web/tests bindings/web/bench bindings/web/serve.mjs build/web
  build/web/node_modules/.bin/tsc --noEmit --strict --target es2022 --module nodenext build/web/tests/types_test.ts ||
    die "the types of the module are wrong: see above"
  export KNEAD=$root/build/release/knead KNEAD_WEB_BUILD=$root/build/web
  export KNEAD_TEST_MESHES=${KNEAD_TEST_MESHES:-$root/../shared/meshes}
  node --test build/web/tests || die "tests of the web failed; see above"
}

web() {
  if [[ ${1:-} == serve ]]; then
    [[ -d out/web ]] || die "nothing is built for the web yet; run: ./dev web"
    exec node bindings/web/serve.mjs out/web "${@:2}"
  fi
  [[ $# -eq 0 ]] || die "web: nothing or serve, not '$*'"
  # Those that are there stay: a node from elsewhere keeps Debian's npm out.
  have emcc || require emscripten || die "what is built for the web needs emscripten"
  have node || require node || die "the module and its tests need node"
  require_build
  export NODE_PATH=/usr/share/nodejs # where Debian has what emscripten needs
  mkdir -p build/web
  require web || die "Studio's page needs the packages above"
  fetch_sources imgui || die "Studio's page needs Dear ImGui's sources, which were not reached; see build/sources/log"
  compile web
  [[ -f build/web/page/knead_studio.wasm ]] || die "Studio's page was not built; CMake said above why"
  rm -rf out/web build/web/site
  mkdir -p out/web
  compile web_threads
  make_site
  cp -r build/web/site/. out/web
  say "made out/web, Studio's page; ./dev web serve shows it"
  cp -r build/web/npm out/web/npm
  say "made out/web/npm, the module of JavaScript"
  compile release knead
  test_web
}

web "$@"
