#!/usr/bin/env bash
# Which module may include which: reads every #include of include, src, apps, bindings, bench and examples and compares
# it with the table below.
#   include_table_test.sh [ROOT]       check the tree under ROOT (default: this repository)
#   include_table_test.sh --table      print the table, for include_graph.sh
#   include_table_test.sh --self-test  prove that each kind of violation is found
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

# module: the modules it may include besides itself | its public headers in include/knead and include/knead/editor (where names
# differ from those above). knead.h includes them all.
# Tests (*_test.cpp) may include any module and tests/support. Everything outside src may include public headers only;
# apps, bindings and benchmarks also json, which is not installed.
readonly table='
math:     | vec error
field:    math | field region
flow:     math field | flow
mesh:     math | mesh
cells:    math mesh | cells
json:     math |
splats:   math mesh |
io:       math mesh cells splats json | io
remesh:   math mesh cells | remesh
pose:     math field flow mesh |
strokes:  math field flow mesh pose | stroke tools
session:  math field flow mesh splats json io remesh pose strokes | session shape_state replay
engineering: math mesh cells remesh strokes session |
certify:  math field flow mesh cells json io remesh strokes session fit | certify
fit:      math field flow mesh pose strokes | fit
skin:     math field flow mesh json io pose strokes fit |
history:  math flow mesh io remesh strokes session | workbench
gl:       math | gl
gpu:      math field flow gl | gpu
render:   math field flow mesh splats io gl | render
'

# file: the internal headers it may include, because it measures what they hold, or needs the same bits everywhere.
readonly measured='
apps/knead/deform_options.cpp:    math/elementary.h
bench/command/counted.cpp:        flow/kernels/kernel_source.h flow/segment_mover.h
bench/remesh_bench.cpp:           mesh/edges.h
bench/pose_scenes.cpp:            mesh/polygonise.h
'

# shellcheck disable=SC2016  # awk's own dollar signs
# Prints "FILE:LINE: what is wrong" for every include that the table does not allow.
readonly checker='
function complain(what) { printf "%s:%d: %s\n", FILENAME, FNR, what }
function check_module(target) {
  if (!(target in modules)) complain("\"" path "\": no module " target)
  else if (module != "" && !is_test && target != module && !((module, target) in allowed))
    complain(module " must not include " target " (\"" path "\")")
}
function check_public(name) {
  if (name == "knead") { if (module != "" && !is_test) complain("a module must not include all of Knead") }
  else if (!(name in owner)) complain("\"" path "\": the table lacks this public header")
  else check_module(owner[name])
}
function check_internal(  uses_json) {
  uses_json = part[1] == "json" && FILENAME !~ /^examples/
  if (is_public) complain("\"" path "\" is internal; a public header includes public ones")
  else if (module == "" && !is_test && !uses_json && !((FILENAME, path) in measured)) complain("\"" path "\" is internal; include a public header")
  else check_module(part[1])
}
function check_app(target) {
  if (app != target) complain((app == "" ? module : app) " must not include the application " target)
}
BEGIN {
  for (n = split(ENVIRON["TABLE"], line, "\n"); n > 0; --n) {
    if (split(line[n], half, /[:|]/) < 2) continue
    modules[half[1]]
    for (k = split(half[2], name, " "); k > 0; --k) allowed[half[1], name[k]]
    for (k = split(half[3], name, " "); k > 0; --k) owner[name[k]] = half[1]
  }
  for (n = split(ENVIRON["MEASURED"], line, "\n"); n > 0; --n) {
    if (split(line[n], half, ":") == 0) continue
    for (k = split(half[2], name, " "); k > 0; --k) measured[half[1], name[k]]
  }
}
FNR == 1 {
  split(FILENAME, part, "/")
  is_public = part[1] == "include"
  header = part[3] == "editor" ? part[4] : part[3]
  sub(/\.h$/, "", header)
  module = part[1] == "src" ? part[2] : is_public && (header in owner) ? owner[header] : ""
  app = part[1] == "apps" ? part[2] : ""
  is_bench = part[1] == "bench"
  is_test = FILENAME ~ /_test\.cpp$/
  if (part[1] == "src" && !(module in modules)) complain("not in a module of the table")
  if (is_public && header != "knead" && !(header in owner)) complain("the table lacks this public header")
}
/^[ \t]*#[ \t]*include[ \t]*["<]/ {
  path = $0
  sub(/^[^"<]*["<]/, "", path)
  sub(/[">].*$/, "", path)
  is_own_style = $0 ~ /include[ \t]*"/
  split(path, part, "/")
  if (path ~ /(^|\/)\.\.\//) complain("\"" path "\": write the path from src/ or the own folder, not with ..")
  else if (path ~ /^knead\/(editor\/)?[a-z_]+\.h$/) {
    header = part[2] == "editor" ? part[3] : part[2]
    sub(/\.h$/, "", header)
    check_public(header)
  }
  else if (part[1] in modules && part[2] != "") check_internal()
  else if (part[1] == "apps" && !is_bench) check_app(part[2])
  else if (part[1] == "bench" && app != "") complain("an application must not include \"" path "\"")
  else if (part[1] == "support") { if (!is_test && !is_bench) complain("only tests and benchmarks may include \"" path "\"") }
  else if (is_own_style && module != "") complain("\"" path "\": no such module")
}
'

violations() {
  (cd "$1" && find include src apps bindings bench examples -mindepth 1 \( -name '*.h' -o -name '*.cpp' \) -print0 | sort -z |
    TABLE=$table MEASURED=$measured xargs -0 -r awk "$checker")
}

check() {
  local found
  found=$(violations "$1")
  [[ -z $found ]] && return 0
  printf '%s\n' "$found" >&2
  echo "The table of who may include whom is in ${BASH_SOURCE[0]}; move the code to the right module instead." >&2
  return 1
}

# tests/include_table/violations is a tree in which every line that breaks the table ends in "// wrong".
self_test() {
  local tree=$here/include_table/violations
  diff <(cd "$tree" && grep -rn '// wrong$' include src apps bindings bench examples | cut -d: -f1,2 | sort) \
    <(violations "$tree" | cut -d: -f1,2 | sort) ||
    { echo "expected (<) and found (>) violations differ, see above" >&2; return 1; }
}

case ${1:-} in
  --self-test) self_test ;;
  --table) sed '/^$/d' <<<"$table" ;;
  *) check "${1:-$here/..}" ;;
esac
