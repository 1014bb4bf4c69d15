#!/usr/bin/env bash
# Puts what the scripts for other systems have noted into the table of docs/packaging.md:  table.sh [FILE]
# A row of which nothing was noted on this machine stays as it is. The last column has the last commit that changed
# what is built.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
file=${1:-docs/packaging.md}
table=$(mktemp)
trap 'rm -f "$table"' EXIT

# Rows that the table has, each with a commit or, from before commits were noted, a word for that.
old_rows() {
  sed -n '/<!-- table -->/,/<!-- end of the table -->/p' "$file" | grep -E '^\| [a-z0-9_]+-' |
    awk -F ' [|] ' 'NF == 6 { sub(/ \|$/, " | earlier |") } { print }'
}

new_rows() {
  local folder cells fact
  for folder in build/cross/facts/*/*; do
    cells=()
    for fact in built started tests bits sources; do
      if [[ -f $folder/$fact ]]; then cells+=("$(<"$folder/$fact")"); else cells+=(no); fi
    done
    printf '| %s | %s | %s | %s | %s | %s | %s |\n' "$(basename "$(dirname "$folder")")" "$(basename "$folder")" "${cells[@]}"
  done
}

{
  printf '| platform | artefact | built | started | tests passed | same bits | commit |\n| --- | --- | --- | --- | --- | --- | --- |\n'
  { new_rows && old_rows; } | awk -F ' [|] ' '!seen[$1 "|" $2]++' | LC_ALL=C sort
} >"$table"
sed -i -e "/<!-- table -->/,/<!-- end of the table -->/{/<!-- table -->/r $table
/<!-- /!d}" "$file"
