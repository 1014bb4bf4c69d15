#!/usr/bin/env bash
# Of a function that several sources define, such as a template or an inline one, the linker takes any. The kernels of
# wider machines must define none that others may define too: it could be taken for everybody, and stop older machines.
#   kernel_symbols_test.sh LIBRARY      check libknead.a
#   kernel_symbols_test.sh --self-test  prove that each kind of violation is found
# Exits with 77, which ctest counts as skipped, where it cannot tell.
set -euo pipefail

skip() {
  echo "skipped: $1"
  exit 77
}

# From the output of nm -A, "OBJECT SYMBOL" for every weak definition of a kernel.
weak_symbols() {
  sed -nE 's/^.*:(kernel_avx(2|512)\.cpp\.o):[0-9a-f]* [WVu] (.*)$/\1 \3/p' | grep -v ' DW\.ref\.__gxx_personality_v0$' | sort -u
}

# The type of the packs says whose a template is. One kernel's must not be in another's source either.
violations() {
  local weak
  weak=$(weak_symbols || true)
  sed -E '/^kernel_avx2.*xsimd.*avx2/d; /^kernel_avx512.*xsimd.*avx512/d; /^$/d' <<<"$weak"
  sed -E 's/^.* //' <<<"$weak" | sort | uniq -d | sed '/^$/d; s/^/several kernels: /'
}

check() {
  local symbols found kernel
  symbols=$(nm -A "$1")
  for kernel in kernel_avx2 kernel_avx512; do
    [[ $symbols == *":$kernel.cpp.o:"* ]] || {
      echo "$1 has no $kernel.cpp.o" >&2
      return 1
    }
  done
  found=$(violations <<<"$symbols")
  [[ -z $found ]] && return 0
  c++filt <<<"$found" >&2
  echo "These would be linked into everything. Inline them always (KNEAD_INLINE), or do without them." >&2
  return 1
}

self_test() {
  local library='libknead.a:kernel_avx2.cpp.o:0000 W _Z4goodN5xsimd4avx2E
libknead.a:kernel_avx512.cpp.o:0000 W _ZSt3mind
libknead.a:kernel_avx2.cpp.o:0000 V DW.ref.__gxx_personality_v0
libknead.a:kernel_avx2.cpp.o:0000 T _Z4ownv
libknead.a:kernel_avx2.cpp.o:     U _ZSt4sqrtf
libknead.a:kernel_avx2.cpp.o:0000 W _ZSt3maxd
libknead.a:kernel_avx512.cpp.o:0000 W _Z4goodN5xsimd8avx512bwE
libknead.a:kernel_avx512.cpp.o:0000 W _Z3badN5xsimd4avx2E
libknead.a:kernel_avx512.cpp.o:0000 W _Z4goodN5xsimd4avx2E
libknead.a:kernel_scalar.cpp.o:0000 W _ZSt3maxf'
  diff <(violations <<<"$library") - <<'EXPECTED' || { echo "found (<) and expected (>) violations differ" >&2; return 1; }
kernel_avx2.cpp.o _ZSt3maxd
kernel_avx512.cpp.o _Z3badN5xsimd4avx2E
kernel_avx512.cpp.o _Z4goodN5xsimd4avx2E
kernel_avx512.cpp.o _ZSt3mind
several kernels: _Z4goodN5xsimd4avx2E
EXPECTED
}

if [[ $1 == --self-test ]]; then
  self_test
  exit
fi
[[ $(uname -m) == x86_64 ]] || skip "the kernels of $(uname -m) are what every machine of that kind runs"
command -v nm >/dev/null || skip "there is no nm here"
check "$1"
