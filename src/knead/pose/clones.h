// Functions that the compiler makes for several instruction sets. Internal to the pose module.
#pragma once

// Marks a function whose loops are vectorised by the compiler: one copy for each instruction set, chosen when the
// program starts. Nothing is contracted or reassociated, so all copies return the same bits. Not under sanitizers,
// which are not ready when the choice is made, and only where the linker knows such functions.
#if defined(__x86_64__) && defined(__linux__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__) && \
    defined(__GNUC__) && !defined(__clang__)
#define KNEAD_CLONES [[gnu::target_clones("default", "avx2", "avx512f")]]
#else
#define KNEAD_CLONES
#endif
