#!/usr/bin/env bash
# Puts all that is given to users into out/release:  release.sh [TARGET...]     (default: all targets of zig.sh)
#   knead-VERSION-SYSTEM.tar.gz or .zip   the command, Studio, and the licences of all that is compiled in
#   knead3d-*.whl, knead_extension.zip    the wheels and the extension that ./dev wheels and ./dev extension have made
#   TESTED.md, SHA256SUMS                 what was tested where, and the checksums
# The table in docs/packaging.md is renewed. The same sources give the same bytes.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
cd "$root"
# shellcheck source=tools/packaging/zig.sh
source tools/packaging/zig.sh
targets=("${@:-${zig_targets[@]}}")
version=$(sed -n 's/^project(knead VERSION \([0-9.]*\).*/\1/p' CMakeLists.txt)
out=out/release
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT

system_of() {
  case $1 in
    *-linux-*) echo "linux-${1%%-*}" ;;
    *-windows-*) echo "windows-${1%%-*}" ;;
    *-macos) echo "macos-${1%%-*}" ;;
  esac
}

# Packs a folder; every file has the same date.
pack() { # FOLDER ARCHIVE
  local archive=$root/$out/$2
  rm -f "$archive"
  find "$scratch/$1" -exec touch -d 2020-01-01T00:00:00Z {} +
  if [[ $2 == *.zip ]]; then
    (cd "$scratch" && "$root/$zig_venv/bin/python" -m zipfile -c "$archive" "$1")
  else
    tar -C "$scratch" --sort=name --owner=0 --group=0 --numeric-owner -c "$1" | gzip -9n >"$archive"
  fi
  printf '%s\n' "$archive"
}

command_of() { # TARGET: the archive of its command
  local target=$1 suffix='' ending=.tar.gz name programs program
  if [[ $target == *-windows-* ]]; then suffix=.exe ending=.zip; fi
  name=knead-$version-$(system_of "$target")
  zig_configure "$target" >&2
  programs=(knead)
  if zig_has "$target" knead-studio; then programs+=(knead-studio); fi
  cmake --build "build/cross/$target" --target "${programs[@]}" >&2
  mkdir -p "$scratch/$name"
  for program in "${programs[@]}"; do cp "build/cross/$target/$program$suffix" "$scratch/$name"; done
  cp README.md "$scratch/$name"
  cp -r build/cross/licences_of_command "$scratch/$name/licences"
  pack "$name" "$name$ending"
}

# shellcheck disable=SC2119  # no further packages
zig_tools
zig_licences build/cross/licences_of_command
mkdir -p "$out"
for target in "${targets[@]}"; do
  archive=$(command_of "$target")
  zig_fact "$target" command built "$(stat -c %s "$archive" | numfmt --to=si)B packed"
done
for made in out/wheels/knead3d-"$version"-*.whl out/knead_extension.zip; do
  if [[ -f $made ]]; then cp "$made" "$out"; else zig_say "without $made"; fi
done
tools/packaging/table.sh
sed -n '/<!-- table -->/,/<!-- end of the table -->/p' docs/packaging.md | grep -v '^<!--' >"$out/TESTED.md"
sums=$(cd "$out" && find . -maxdepth 1 -type f ! -name SHA256SUMS -printf '%f\n' | LC_ALL=C sort | xargs sha256sum)
printf '%s\n' "$sums" >"$out/SHA256SUMS"
zig_say "$(wc -l <"$out/SHA256SUMS") files in $out"
