#pragma once

#include <cstddef>  // defines __GLIBC__, where the library is glibc

/// CHASLES_VECTOR_CLONES before a function: it and all that it calls are also compiled for
/// processors with AVX2, and the loader chooses. One binary serves all x86-64 processors. The bytes
/// of the result do not depend on the choice: the code sums lane by lane in a fixed order, and
/// -ffp-contract=off keeps products and sums apart.
///
/// Sanitizers instrument the loader's function, which runs before they are set up.
#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || \
    __has_feature(memory_sanitizer)
#define CHASLES_SANITIZED
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define CHASLES_SANITIZED
#endif

#if defined(__x86_64__) && defined(__GLIBC__) && !defined(CHASLES_SANITIZED)
#define CHASLES_VECTOR_CLONES [[gnu::target_clones("avx2", "default"), gnu::flatten]]
#else
#define CHASLES_VECTOR_CLONES
#endif
