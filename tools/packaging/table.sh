#!/usr/bin/env bash
# Puts what the scripts for other systems have noted into the table of docs/packaging.md:  table.sh [FILE]
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
file=${1:-docs/packaging.md}
table=$(mktemp)
trap 'rm -f "$table"' EXIT
{
  printf '| platform | artefact | built | started | tests passed | same bits |\n| --- | --- | --- | --- | --- | --- |\n'
  for folder in build/cross/facts/*/*; do
    cells=()
    for fact in built started tests bits; do
      if [[ -f $folder/$fact ]]; then cells+=("$(<"$folder/$fact")"); else cells+=(no); fi
    done
    printf '| %s | %s | %s | %s | %s | %s |\n' "$(basename "$(dirname "$folder")")" "$(basename "$folder")" "${cells[@]}"
  done
} >"$table"
sed -i -e "/<!-- table -->/,/<!-- end of the table -->/{/<!-- table -->/r $table
/<!-- /!d}" "$file"
