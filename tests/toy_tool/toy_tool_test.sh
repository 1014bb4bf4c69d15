#!/usr/bin/env bash
# Adds a toy tool to a copy of the sources by the list in CONTRIBUTING.md, no file more and none less, and runs a session
# with it.   toy_tool_test.sh WORK LIBRARIES COMPILER...   (a folder of its own, libknead.a and what it needs, how to
# compile)
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$here/../..
work=$1
read -ra libraries <<<"$2"
compile=("${@:3}")

# The files in backticks at the head of each item of the list, with NAME for the tool.
# shellcheck disable=SC2016  # the backticks are what it looks for
listed() {
  sed -n '/^## Adding a tool/,/^## /p' "$root/CONTRIBUTING.md" | sed -nE 's/^[0-9]+\. `([^`]+)`.*/\1/p' |
    sed 's/NAME/toy/' | sort
}
added() { (cd "$here/tree" && find . -type f | sed -E 's|^\./||; s|\.sed$||' | sort); }

diff <(listed) <(added) || { echo "CONTRIBUTING.md lists (<) other files than the toy tool needs (>)" >&2; exit 1; }
count=$(added | wc -l)
echo "a new tool touches $count files"
[[ $count -le 7 ]] || { echo "more than 7" >&2; exit 1; }

rm -rf "$work" && mkdir -p "$work"
(cd "$root" && cp --parents -r include src apps/studio docs/session.md CHANGELOG.md tests/surveys tests/support "$work")
while read -r file; do
  if [[ -f $here/tree/$file ]]; then
    cp "$here/tree/$file" "$work/$file"
  else
    sed -i.before -f "$here/tree/$file.sed" "$work/$file"
    ! cmp -s "$work/$file" "$work/$file.before" || { echo "$file: the edit changed nothing" >&2; exit 1; }
  fi
done < <(added)

# Every source that handles strokes of any tool; the rest comes from the library.
cd "$work"
sources() {
  sed -nE 's|^ *(strokes/[a-z_]+\.cpp).*|src/\1|p' src/CMakeLists.txt
  printf '%s\n' src/session/{session,session_text,stroke_json}.cpp apps/studio/{keys,gestures/tools}.cpp \
    tests/surveys/random_strokes.cpp "$here/main.cpp"
}
mkdir objects
mapfile -t all < <(sources)
running=0
for ((i = 0; i < ${#all[@]}; i += 6)); do # at once, as KNEAD_UNITY does
  printf '#include "%s"\n' "${all[@]:i:6}" >"objects/$i.cpp"
  "${compile[@]}" -O0 -I . -I include -I src -I apps/studio -I tests -c "objects/$i.cpp" -o "objects/$i.o" &
  ((++running % 2)) || wait
done
wait
# The library may hold several sources in one object (KNEAD_UNITY), so what is replaced comes twice: the first one counts.
"${compile[@]}" -Wl,--allow-multiple-definition objects/*.o "${libraries[@]}" -lfmt -ltbb -pthread -o toy_tool
./toy_tool docs/session.md
