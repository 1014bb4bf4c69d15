#!/usr/bin/env bash
# Runs the command for Linux in a bare Debian 11, whose glibc 2.31 is that of Ubuntu 20.04, without a single package more, and
# then Studio, with the X11 and OpenGL that every desktop has, by the hand of tests/studio/window_test.sh:
#   old_linux_test.sh [ARCHIVE [ROOT]]     (default: out/release/knead-*-linux-x86_64.tar.gz; root and debootstrap are needed)
# ROOT is kept, else removed. KNEAD names the command whose bytes must come (default: build/release/knead).
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
archive=$(realpath "${1:-$(printf '%s\n' "$here"/out/release/knead-*-linux-x86_64.tar.gz | sed -n 1p)}")
knead=$(realpath "${KNEAD:-$here/build/release/knead}")
root=${2:-$(mktemp -d)}
scratch=$(mktemp -d)
# shellcheck disable=SC2317  # called by the trap
clean() {
  umount "$root/tmp" 2>/dev/null || true
  rm -rf "$scratch"
  if [[ -z ${keep:-} ]]; then rm -rf "$root"; fi
}
keep=${2:-}
trap clean EXIT
# shellcheck disable=SC2016  # a format of apt
mirror=${MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | sed -n 1p)}
[[ -f $root/etc/debian_version ]] || debootstrap --variant=minbase bullseye "$root" "$mirror" >"$scratch/debootstrap.log" || {
  tail "$scratch/debootstrap.log" >&2
  exit 1
}
rm -rf "$root/knead" && mkdir "$root/knead"
tar -xzf "$archive" -C "$root/knead" --strip-components=1
cp "$here/examples/tools/implicit.knead" "$root/knead"
inside() { chroot "$root" /bin/sh -c "cd /knead && $1"; }
inside './knead make sphere -n 4000 -q -o sphere_64k.ply && ./knead deform sphere_64k.ply implicit.knead -q -o pulled.ply'
(cd "$scratch" && "$knead" make sphere -n 4000 -q -o sphere_64k.ply &&
  "$knead" deform sphere_64k.ply "$root/knead/implicit.knead" -q -o pulled.ply)
cmp "$scratch/pulled.ply" "$root/knead/pulled.ply"
inside './knead --version && ldd --version | sed -n 1p'
glibc=$(inside 'ldd --version' | sed -n '1s/.* /glibc /p')
studio=
if [[ -x $root/knead/knead-studio ]]; then
  inside 'apt-get update && apt-get install -y --no-install-recommends libx11-6 libxi6 libgl1 libegl1 libgl1-mesa-dri' \
    >"$scratch/apt.log" 2>&1 || {
    tail "$scratch/apt.log" >&2
    exit 1
  }
  mount --bind /tmp "$root/tmp" # where the test of the window has its files
  printf '#!/bin/sh\nexec chroot %q /knead/knead-studio "$@"\n' "$root" >"$scratch/studio.sh"
  chmod +x "$scratch/studio.sh"
  studio=failed
  if "$here/tests/studio/window_test.sh" "$knead" "$scratch/studio.sh"; then studio=passed; fi
fi
cd "$here"
# shellcheck source=tools/packaging/zig.sh
source tools/packaging/zig.sh
zig_fact x86_64-linux-gnu.2.17 command tests "tests/package/old_linux_test.sh, $glibc"
if [[ -n $studio ]]; then
  zig_fact x86_64-linux-gnu.2.17 studio tests "tests/studio/window_test.sh, with $glibc, $studio"
  [[ $studio == passed ]]
fi
