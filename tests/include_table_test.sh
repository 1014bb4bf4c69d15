#!/usr/bin/env bash
# Which room may include which: reads every #include of src/knead, apps, bench and examples and compares it with the
# table below.
#   include_table_test.sh [ROOT]       check the tree under ROOT (default: this repository)
#   include_table_test.sh --self-test  prove that each kind of violation is found
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)

# room: the rooms it may include besides itself. Tests (*_test.cpp) may include any room and tests/support.
# apps, python, paraview, web, bench, examples and public headers may include public headers only: those that a CMakeLists.txt under src/knead
# lists after FILE_SET HEADERS.
readonly table='
math:
field:   math
flow:    math field
mesh:    math
io:      math mesh
remesh:  math mesh
pose:    math field flow
tool:    math field flow mesh pose
fit:     math field flow mesh pose tool
session: math field flow mesh io remesh pose tool fit
gl:      math
gpu:     math field flow gl
render:  math field flow mesh gl
'

# file: the internal headers it may include, because it measures what they hold.
readonly measured='
apps/knead/benchmark/counted.cpp: knead/flow/kernel_source.h knead/flow/segment_mover.h
bench/remesh_bench.cpp:           knead/mesh/edges.h
bench/pose_scenes.cpp:            knead/mesh/polygonise.h
'

# shellcheck disable=SC2016  # awk's own dollar signs
# Prints "FILE:LINE: what is wrong" for every include that the table does not allow. PUBLIC: the public headers, one on
# each line.
readonly checker='
function complain(what) { printf "%s:%d: %s\n", FILENAME, FNR, what }
function check_room(target) {
  if (!(target in rooms)) complain("\"" path "\": no room " target)
  else if (room != "" && !is_test && target != room && !((room, target) in allowed))
    complain(room " must not include " target " (\"" path "\")")
}
function check_public() {
  if ((room == "" || is_installed) && !is_test && !(path in is_public) && !((FILENAME, path) in measured)) complain("\"" path "\" is internal; include a public header")
}
function check_app(target) {
  if (app != target) complain((app == "" ? room : app) " must not include the application " target)
}
BEGIN {
  for (n = split(ENVIRON["PUBLIC"], header, "\n"); n > 0; --n) is_public[header[n]]
  for (n = split(ENVIRON["TABLE"], line, "\n"); n > 0; --n) {
    if (split(line[n], half, ":") == 0) continue
    rooms[half[1]]
    for (k = split(half[2], name, " "); k > 0; --k) allowed[half[1], name[k]]
  }
  for (n = split(ENVIRON["MEASURED"], line, "\n"); n > 0; --n) {
    if (split(line[n], half, ":") == 0) continue
    for (k = split(half[2], name, " "); k > 0; --k) measured[half[1], name[k]]
  }
}
FNR == 1 {
  split(FILENAME, part, "/")
  room = part[1] == "src" && part[4] != "" ? part[3] : ""  # knead.h is in no room
  app = part[1] == "apps" ? part[2] : ""
  is_bench = part[1] == "bench"
  is_installed = substr(FILENAME, 5) in is_public
  is_test = FILENAME ~ /_test\.cpp$/
  if (room != "" && !(room in rooms)) complain("not in a room of the table")
}
/^[ \t]*#[ \t]*include[ \t]*["<]/ {
  path = $0
  sub(/^[^"<]*["<]/, "", path)
  sub(/[">].*$/, "", path)
  split(path, part, "/")
  if (path ~ /(^|\/)\.\.\//) complain("\"" path "\": write the path from src/ or the own folder, not with ..")
  else if (part[1] == "knead" && part[3] == "") check_public()
  else if (part[1] == "knead") { check_room(part[2]); check_public() }
  else if (part[1] == "apps" && !is_bench) check_app(part[2])
  else if (part[1] == "bench" && app != "") complain("an application must not include \"" path "\"")
  else if (part[1] == "support") { if (!is_test && !is_bench) complain("only tests and benchmarks may include \"" path "\"") }
}
'

# Prints the public headers of the tree as they are included.
public_headers() {
  (cd "$1/src" && find knead -name CMakeLists.txt | while read -r list; do
    sed -n '/FILE_SET HEADERS/,/)/p' "$list" | { grep -o '[a-z0-9_/]*\.h\>' || true; } | sed "s|^|$(dirname "$list")/|"
  done)
}

violations() {
  (cd "$1" && find src/knead apps python paraview bench examples web -mindepth 1 \( -name '*.h' -o -name '*.cpp' \) -print0 | sort -z |
    TABLE=$table MEASURED=$measured PUBLIC=$(public_headers .) xargs -0 -r awk "$checker")
}

# More would no longer fit on a page.
readonly most_public=63

check() {
  local found count
  count=$(public_headers "$1" | wc -l)
  if ((count > most_public)); then
    echo "$count public headers, at most $most_public: take those that no user needs out of FILE_SET HEADERS" >&2
    return 1
  fi
  found=$(violations "$1")
  [[ -z $found ]] && return 0
  printf '%s\n' "$found" >&2
  echo "The table of who may include whom is in ${BASH_SOURCE[0]}; move the code to the right room instead." >&2
  return 1
}

# tests/include_table/violations is a tree in which every line that breaks the table ends in "// wrong".
self_test() {
  local tree=$here/include_table/violations
  diff <(cd "$tree" && grep -rn '// wrong$' src apps python paraview bench examples web | cut -d: -f1,2 | sort) \
    <(violations "$tree" | cut -d: -f1,2 | sort) ||
    { echo "expected (<) and found (>) violations differ, see above" >&2; return 1; }
}

if [[ ${1:-} == --self-test ]]; then self_test; else check "${1:-$here/..}"; fi
