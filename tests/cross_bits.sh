#!/usr/bin/env bash
# Whether a build of the command for another system writes the same bytes as that of this machine:
#   cross_bits.sh KNEAD SETS THEIRS...   (as build/release/knead "scalar neon" qemu-aarch64-static OTHER/knead)
# KNEAD runs each job with every set of instructions that it has, THEIRS with each of SETS. Prints how many outputs were
# compared; where one differs, names it, and fails. KNEAD_BITS_FOLDER keeps the files there.
set -euo pipefail

root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
ours=$(realpath "$1")
read -ra sets <<<"$2"
shift 2
theirs=("$@")
scratch=${KNEAD_BITS_FOLDER:-$(mktemp -d)}
if [[ -z ${KNEAD_BITS_FOLDER:-} ]]; then trap 'rm -rf "$scratch"' EXIT; fi

# All jobs, by the command that is given, into the folder that this runs in.
jobs_of() {
  local kind name shape format
  run() { "${command[@]}" "$@" || echo "knead $1 failed with $?: ${*:2}" >>failed.txt; }
  command=("$@")
  for kind in sphere box cylinder torus hand crater knot letter-y figure; do run make "$kind" -n 4000 -q -o "$kind.ply"; done
  cp sphere.ply sphere_64k.ply
  run make sphere -n 2562 -q -o sphere_coarse.ply
  for format in obj stl off glb xyz pcd; do run make hand -n 4000 -q -o "hand.$format"; done
  for name in "$root"/examples/tools/*.knead; do
    shape=$(sed -n '1s/.*"mesh": "\([^"]*\)".*/\1/p' "$name")
    name=$(basename "$name" .knead)
    grep -v '"text"' "$root/examples/tools/$name.knead" >"$name.knead" # which fonts there are is the system's matter
    run deform "$shape" "$name.knead" -q -o "$name.ply"
    run deform "$shape" "$name.knead" -q --precision double --integrator rk4 -o "$name.double.ply"
    run resolve "$shape" "$name.knead" -q -o "$name.resolved.knead"
  done
  cp "$root"/examples/gallery/fig_pose_figure.knead .
  run deform figure.ply fig_pose_figure.knead -q -o pose_session.ply
  for name in implicit twist bend paint; do
    shape=$(sed -n '1s/.*"mesh": "\([^"]*\)".*/\1/p' "$name.knead")
    run deform "$shape" "$name.knead" -q --remesh -o "$name.remeshed.ply"
  done
  run remesh crater.ply -q -o crater.remeshed.obj
  for format in obj stl off glb xyz pcd; do run deform "hand.$format" bend.knead -q -o "bend.$format"; done
  run deform hand.obj bend.knead -q --digits shortest -o bend.shortest.obj
  run deform hand.ply bend.knead -q --frames 3 -o bend.frames.glb
  run deform hand.ply bend.knead -q --frames 3 -o bend.frames.pc2
  run deform - bend.knead --format ply -q -o - <hand.ply >bend.piped.ply
  run deform - bend.knead --format obj -q -o - <hand.obj >bend.piped.obj
  run fit hand.ply pose.ply --surface -q -o fitted.knead
  run info bend.ply --json >info.json
  run check bend.ply --json >check.json
}

# The jobs with one set of instructions, in a folder of their own; its name.
with_set() {
  local folder=$1 set=$2
  shift 2
  mkdir -p "$scratch/$folder"
  # Quiet on what was refused: that is an output, too, with the folder's name left out.
  (cd "$scratch/$folder" && KNEAD_SIMD=$set jobs_of "$@" 2>messages.txt </dev/null)
  sed -i -e 's/\r$//' "$scratch/$folder/messages.txt"
  (cd "$scratch/$folder" && sha256sum -- *) >"$scratch/$folder.sums"
}

# Whether this machine has a set.
has_set() {
  (cd "$scratch" && "$ours" make sphere -n 1000 -q -o probe.ply &&
    KNEAD_SIMD=$1 "$ours" deform probe.ply "$root/examples/tools/implicit.knead" -q -o probe.ply 2>/dev/null)
}

reference=
for set in scalar avx2 avx512 neon; do
  has_set "$set" || continue
  with_set "ours-$set" "$set" "$ours"
  reference=${reference:-$scratch/ours-$set.sums}
done
status=0
if [[ -f ${reference%.sums}/failed.txt ]]; then
  cat "${reference%.sums}/failed.txt"
  status=1
fi
for sums in "$scratch"/ours-*.sums; do
  if ! difference=$(diff "$reference" "$sums"); then
    printf 'this machine, %s:\n%s\n' "$(basename "$sums" .sums)" "$difference"
    status=1
  fi
done
for set in "${sets[@]}"; do
  with_set "theirs-$set" "$set" "${theirs[@]}"
  if ! difference=$(diff "$reference" "$scratch/theirs-$set.sums"); then
    printf '%s with %s differs:\n%s\n' "${theirs[*]}" "$set" "$difference"
    status=1
  fi
done
if [[ $status == 0 ]]; then
  printf '%d outputs, the same with %s\n' "$(wc -l <"$reference")" "${sets[*]}"
fi
exit $status
