#!/usr/bin/env bash
# Installs the Debian packages into a bare Debian 12, uses them there, and removes them again. Run by hand, as root, after
# `./dev package` (CONTRIBUTING.md, "Packaging"):
#   chroot_test.sh [PACKAGES [ROOT]]
# PACKAGES is the folder of the .deb files (out/package). ROOT is made by debootstrap from $MIRROR, by default the system's
# own package server, and removed at the end, unless the caller names it.
# shellcheck disable=SC2016 # what is in single quotes is for the shell in the root to expand
set -euo pipefail

source_dir=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
packages=$(cd "${1:-$source_dir/out/package}" && pwd)
mirror=${MIRROR:-$(apt-get indextargets --format '$(REPO_URI)' 'Created-By: Packages' | sed -n 1p)}
checks=0

say() { printf '\n== %s\n' "$*"; }
die() {
  printf 'chroot_test: %s\n' "$*" >&2
  exit 1
}
passed() {
  checks=$((checks + 1))
  printf 'passed: %s\n' "$*"
}

[[ $EUID -eq 0 ]] || die "run it as root: it makes a root folder of its own"
command -v debootstrap >/dev/null || die "install debootstrap"
debs=("$packages"/knead_*.deb "$packages"/libknead-dev_*.deb)
[[ ${#debs[@]} -eq 2 && -f ${debs[0]} && -f ${debs[1]} ]] || die "$packages needs one knead_*.deb and one libknead-dev_*.deb"
version=$(dpkg-deb -f "${debs[0]}" Version)

if [[ $# -ge 2 ]]; then
  mkdir -p "$2"
  root=$(cd "$2" && pwd)
  keep=yes
else
  root=$(mktemp -d /var/tmp/knead_chroot.XXXXXX)
  chmod 755 "$root" # apt's own user must be able to read it
  keep=no
fi
clean_up() {
  if mountpoint -q "$root/proc"; then umount "$root/proc" || return; fi
  if [[ $keep == no ]]; then rm -rf --one-file-system "$root"; fi
}
trap clean_up EXIT

# Runs a command in the root, with little of the caller's environment.
inside() { chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/tmp LC_ALL=C.UTF-8 DEBIAN_FRONTEND=noninteractive "$@"; }
# Runs a bash script in the root, in the folder of the test's files.
script() { inside bash -euo pipefail -c "cd /tmp/test; $1"; }
apt() { inside apt-get -qq -y --no-install-recommends "$@" >"$root/tmp/apt.log" 2>&1 || die "apt-get $*: $(tail -5 "$root/tmp/apt.log")"; }
# Prints every file that a package may have to remove again; caches, logs and apt's own lists are left out.
files() {
  inside find / -xdev \( -path /proc -o -path /sys -o -path /dev -o -path /tmp -o -path /var/cache \
    -o -path /var/log -o -path /var/lib/apt -o -path /var/lib/dpkg \) -prune -o -print | sort
}

say "a bare Debian 12 in $root"
[[ -f $root/etc/debian_version ]] || debootstrap --variant=minbase bookworm "$root" "$mirror" >"$root.log" || die "see $root.log"
rm -f "$root.log"
mount -t proc proc "$root/proc" || die "cannot mount /proc in $root"
cp /etc/resolv.conf "$root/etc/resolv.conf"
inside apt-get -qq update
# What only this test needs is there before Knead is.
apt install man-db bash-completion desktop-file-utils shared-mime-info libxml2-utils zsh g++ cmake ninja-build pkg-config
rm -rf "$root/tmp/test"
mkdir -p "$root/tmp/test/tests"
cp "${debs[@]}" "$root/tmp/test"
cp -r "$source_dir/examples" "$root/tmp/test"
cp -r "$source_dir/tests/consumer" "$root/tmp/test/tests"
files >"$root/tmp/before"
inside dpkg-query -W -f '${Package}\n' | sort >"$root/tmp/packages_before"

say "installing knead $version"
apt install "/tmp/test/$(basename "${debs[0]}")"
[[ $(script 'knead --version') == "knead ${version%-*}" ]] || die "knead --version does not print ${version%-*}"
passed "knead --version"
script 'knead make hand -o hand.ply && knead deform hand.ply examples/peace.knead -o peace.ply && knead check peace.ply --require closed,manifold >check.txt'
passed "knead make, deform and check"
script 'grep -q vertex_steps_per_s <<<"$(knead bench --json --mesh hand.ply)"' || die "knead bench does not measure"
passed "knead bench"
script 'knead-studio --version' || die "knead-studio does not start"
passed "knead-studio --version"
script 'for page in knead knead-deform knead-studio; do man "$page" | grep "^NAME"; done; man knead deform | grep -- --require' >/dev/null
passed "man knead, man knead deform"
script 'set +u; source /usr/share/bash-completion/bash_completion; _completion_loader knead || [[ $? -eq 124 ]]; complete -p knead
  COMP_WORDS=(knead deform --int); COMP_CWORD=2; _knead; [[ ${COMPREPLY[*]} == --integrator ]]'
passed "completion in bash"
script 'zsh -fc "autoload -U compinit; compinit -u -d /tmp/zcompdump; [[ \$_comps[knead] == _knead ]]"; zsh -n /usr/share/zsh/vendor-completions/_knead'
passed "completion in zsh"
script 'desktop-file-validate /usr/share/applications/knead-studio.desktop; xmllint --noout /usr/share/mime/packages/knead.xml
  grep -q "application/x-knead:\*.knead" /usr/share/mime/globs2
  grep -q "^application/x-knead=knead-studio.desktop" /usr/share/applications/mimeinfo.cache'
passed "*.knead is opened by Studio"

say "building the consumer with libknead-dev"
apt install "/tmp/test/$(basename "${debs[1]}")"
script "cmake -S tests/consumer -B build -G Ninja --log-level=ERROR -DKNEAD_VERSION=$(cut -d. -f1,2 <<<"$version") && cmake --build build --target pull"
script 'build/pull hand.ply pulled.ply && knead info pulled.ply | grep vertices'
passed "find_package(knead), and a program that uses it"

say "removing both"
apt purge knead libknead-dev
apt autoremove --purge
inside dpkg-query -W -f '${Package}\n' | sort >"$root/tmp/packages_after"
files >"$root/tmp/after"
diff "$root/tmp/packages_before" "$root/tmp/packages_after" || die "packages are left, see above"
diff "$root/tmp/before" "$root/tmp/after" || die "files are left, see above"
passed "nothing is left"

printf '\n%d checks passed with %s\n' "$checks" "$(basename "${debs[0]}")"
