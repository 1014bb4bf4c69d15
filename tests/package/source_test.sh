#!/usr/bin/env bash
# Does README's two commands in a bare tree of a Debian suite, and writes the row of it in docs/packaging.md:
#   source_test.sh SUITE [COMPILER [ROOT]]     as: source_test.sh trixie clang-19; as root, with debootstrap installed
# What is built is the last commit. COMPILER is a package, by default g++. ROOT is kept, else removed. KNEAD names the command whose
# bytes must come (default: build/release/knead; without it they are not compared), KNEAD_TESTS the tests: arguments of ctest, or
# none, which builds and compares the command alone.
# With CCACHE_DIR set, ccache is used there, too.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
die() {
  printf 'source_test: %s\n' "$*" >&2
  exit 1
}
[[ $# -ge 1 && $# -le 3 ]] || die "source_test.sh SUITE [COMPILER [ROOT]]"
[[ $EUID -eq 0 ]] || die "run it as root: it makes a root folder of its own"
command -v debootstrap >/dev/null || die "install debootstrap"
# What is mounted is gone with the process.
[[ -n ${KNEAD_UNSHARED:-} ]] || KNEAD_UNSHARED=yes exec unshare --mount --propagation private "${BASH_SOURCE[0]}" "$@"

suite=$1
package=${2:-g++}
compiler=${package/clang/clang++}
scratch=$(mktemp -d)
root=${3:-$(mktemp -d /var/tmp/knead_source.XXXXXX)}
# shellcheck disable=SC2317  # called by the trap
clean_up() {
  umount -R "$root/dev" "$root/proc" "$root/tmp" "$root/var/cache/ccache" 2>/dev/null || true
  rm -rf "$scratch"
  if [[ -z $keep ]]; then rm -rf --one-file-system "$root"; fi
}
keep=${3:-}
trap clean_up EXIT

inside() {
  chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 CXX="$compiler" \
    ${CCACHE_DIR:+CCACHE_DIR=/var/cache/ccache CCACHE_MAXSIZE="${CCACHE_MAXSIZE:-5G}" CCACHE_SLOPPINESS="${CCACHE_SLOPPINESS:-}"} \
    bash -c "cd /knead && $1"
}

make_root() {
  # shellcheck disable=SC2016  # a format of apt
  local mirror=${MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | sed -n 1p)}
  [[ -f $root/etc/debian_version ]] || debootstrap --variant=minbase "$suite" "$root" "$mirror" >"$scratch/log" ||
    die "$(tail "$scratch/log")"
  chmod 755 "$root" # apt's own user must be able to read it
  echo 'Acquire::Check-Valid-Until "false";' >"$root/etc/apt/apt.conf.d/90knead" # a mirror may be behind
  cp -L /etc/resolv.conf /etc/hosts "$root/etc"
  mount -t proc proc "$root/proc"
  mount --rbind /dev "$root/dev"
  mount --bind /tmp "$root/tmp" # where the bytes are compared
  if [[ -n ${CCACHE_DIR:-} ]]; then
    mkdir -p "$root/var/cache/ccache"
    mount --bind "$CCACHE_DIR" "$root/var/cache/ccache"
  fi
  rm -rf --one-file-system "$root/knead"
  git -c safe.directory="$here/.git" clone -q --no-hardlinks "file://$here" "$root/knead"
  inside "apt-get -qq update && apt-get -qq install -y --no-install-recommends $package ${CCACHE_DIR:+ccache}" >"$scratch/log" 2>&1 ||
    die "$(tail "$scratch/log")"
}

same_bits() {
  local ours=${KNEAD:-$here/build/release/knead}
  [[ -x $ours ]] || {
    echo no
    return
  }
  # shellcheck disable=SC2016  # for the shell in the root
  printf '#!/bin/sh\nexec chroot %q /bin/sh -c '\''cd "$0" && exec /knead/build/release/knead "$@"'\'' "$PWD" "$@"\n' "$root" \
    >"$scratch/theirs"
  chmod +x "$scratch/theirs"
  if "$here/tests/cross_bits.sh" "$ours" "$(sets_here)" "$scratch/theirs" >"$scratch/bits"; then
    cat "$scratch/bits"
  else
    cat "$scratch/bits" >&2
    echo differ
  fi
}
# The sets of instructions that this machine has.
sets_here() {
  local set flag
  for set in avx2:avx2 avx512:avx512bw neon:asimd; do
    flag=${set#*:}
    if grep -qw "$flag" /proc/cpuinfo; then printf '%s ' "${set%:*}"; fi
  done
  echo scalar
}

# Says which tests were run where not all were. A bar would end the cell of the table.
part_of_tests() {
  [[ -z ${KNEAD_TESTS:-} ]] || echo "; only \`${KNEAD_TESTS//|/\\|}\`"
}

write_row() {
  local file=$here/docs/packaging.md row
  row="| $suite | $(inside "$compiler --version" | sed -n 1p) | $1 | $2 | $3 | $(git -c safe.directory="$root/knead" -C "$root/knead" rev-parse --short=8 HEAD) |"
  row=$row awk '
    function key(text, cells) { split(text, cells, " [|] "); sub(/ .*/, "", cells[2]); return cells[1] cells[2] }
    /<!-- sources -->/ { within = 1 }
    within && /^\| [a-z]+ \|/ && key($0) == key(ENVIRON["row"]) { next }
    /<!-- end of the sources -->/ { print ENVIRON["row"]; within = 0 }
    { print }' "$file" >"$scratch/page"
  cp "$scratch/page" "$file"
}

make_root
demo=failed
tests=no
bits=no
if inside './dev demo' >"$scratch/demo" 2>&1; then
  demo=yes
  bits=$(same_bits)
  if [[ ${KNEAD_TESTS:-} != none ]]; then
    inside "./dev test ${KNEAD_TESTS:-}" 2>&1 | tee "$scratch/tests" || true
    tests=$(sed -nE 's/^[0-9]+% tests passed, ([0-9]+) tests? failed out of ([0-9]+)$/\1 of \2 failed/p' "$scratch/tests" | tail -n 1)
    tests="${tests:-not built}, $(grep -c '\*\*\*Skipped' "$scratch/tests" || true) skipped$(part_of_tests)"
  fi
else
  tail -n 40 "$scratch/demo" >&2
fi
write_row "$demo" "$tests" "$bits"
[[ $demo == yes && ($tests == "0 of "* || ${KNEAD_TESTS:-} == none) && $bits != differ ]]
