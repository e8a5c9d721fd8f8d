#pragma once

#include <cstddef>  // defines __GLIBC__, where the library is glibc

/// CHASLES_VECTOR_CLONES before a function: g++ compiles it and all that it calls for processors
/// with AVX2 too, and the loader chooses. One binary serves all x86-64 processors. The bytes of the
/// result do not depend on the choice: the code sums lane by lane in a fixed order, and
/// -ffp-contract=off keeps products and sums apart. Clang has no such pair of attributes, and makes
/// one version; CI compares the bytes of both compilers.
#if defined(__x86_64__) && defined(__GLIBC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// Sanitizers would instrument the loader's function, which runs before they are set up.
#define CHASLES_VECTOR_CLONES [[gnu::target_clones("avx2", "default"), gnu::flatten]]
#else
#define CHASLES_VECTOR_CLONES
#endif
