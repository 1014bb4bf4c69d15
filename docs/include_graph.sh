#!/usr/bin/env bash
# Draws which module includes which: one node for each module of src and each program of apps, one arrow for each
# pair of modules with an #include between them (tests left out). An arrow that follows from others is drawn in grey.
#   docs/include_graph.sh           writes docs/images/include_graph.dot and, with graphviz, include_graph.svg
#   docs/include_graph.sh --print   prints the DOT text of today's includes
#   docs/include_graph.sh --check   fails if the committed DOT or SVG shows other arrows than today's includes
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
dot_file=$root/docs/images/include_graph.dot
svg_file=$root/docs/images/include_graph.svg

# shellcheck disable=SC2016  # awk's own dollar signs
# Prints "FROM TO" for every #include of another module. The table of tests/include_table_test.sh says whose a public header is.
readonly finding='
BEGIN {
  for (n = split(ENVIRON["TABLE"], line, "\n"); n > 0; --n) {
    split(line[n], half, /[:|]/)
    modules[half[1]]
    for (k = split(half[3], name, " "); k > 0; --k) owner["knead/" name[k] ".h"] = half[1]
  }
}
FNR == 1 {
  split(FILENAME, part, "/")
  from = part[1] == "src" ? part[2] : part[1] == "apps" ? "apps/" part[2] : owner[substr(FILENAME, 9)]
}
/^#include "/ {
  path = substr($2, 2, length($2) - 2)
  split(path, part, "/")
  to = path in owner ? owner[path] : part[2] != "" && part[1] in modules ? part[1] : ""
  if (from != "" && to != "" && to != from) print from, to
}
'

# Prints each arrow once, sorted.
arrows() {
  (cd "$root" && find include src apps -mindepth 2 \( -name '*.h' -o -name '*.cpp' \) ! -name '*_test.cpp' -print0 |
    TABLE=$(bash tests/include_table_test.sh --table) xargs -0 awk "$finding") | LC_ALL=C sort -u
}

# shellcheck disable=SC2016  # awk's own dollar signs
# Turns the arrows into DOT: programs are boxes, optional modules dashed, implied arrows grey.
readonly drawing='
{ to[$1, $2]; module[$1]; module[$2]; line[NR] = $0 }
# Whether another path than the arrow itself leads from a to b.
function implied(a, b,   c) {
  for (c in module) if (c != b && (a, c) in to && ((c, b) in to || implied(c, b))) return 1
  return 0
}
function style(name) {
  if (name ~ /^apps\//) return "shape=box, fillcolor=\"#e2cdaa\""
  if (name ~ /^(gl|gpu|render)$/) return "style=\"filled,dashed\", fillcolor=white"
  return "fillcolor=\"#f4ece0\""
}
END {
  print "digraph modules {"
  print "  bgcolor=white; nodesep=0.35; ranksep=0.45;"
  print "  node [shape=ellipse, style=filled, fontname=\"DejaVu Sans\", fontsize=13, color=\"#55504a\"];"
  print "  edge [color=\"#55504a\", arrowsize=0.7];"
  for (i = 1; i <= NR; ++i) {
    split(line[i], end, " ")
    for (k = 1; k <= 2; ++k) if (!seen[end[k]]++) printf "  \"%s\" [%s];\n", end[k], style(end[k])
    printf "  \"%s\" -> \"%s\"%s;\n", end[1], end[2], implied(end[1], end[2]) ? " [color=\"#d8d2c8\"]" : ""
  }
  print "}"
}
'

print_dot() { arrows | awk "$drawing"; }

check() {
  local stale="run docs/include_graph.sh to renew the picture"
  diff "$dot_file" <(print_dot) >&2 || { echo "$dot_file differs from today's includes; $stale" >&2; return 1; }
  diff <(arrows | sed 's/ / -> /') \
    <(sed -n 's/^<title>\(.*\)&#45;&gt;\(.*\)<\/title>$/\1 -> \2/p' "$svg_file" | LC_ALL=C sort -u) >&2 ||
    { echo "$svg_file shows other arrows than $dot_file; $stale" >&2; return 1; }
}

case ${1:-} in
  --print) print_dot ;;
  --check) check ;;
  *)
    print_dot >"$dot_file"
    if command -v dot >/dev/null; then dot -Tsvg "$dot_file" -o "$svg_file"; fi
    ;;
esac
