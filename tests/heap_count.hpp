#pragma once

#include <cstddef>

namespace chasles::test {

/// What the process has from the heap, by every way there is (operator new, Eigen, C).
struct HeapCount {
  long allocations = 0;  ///< calls so far, those that OpenBLAS makes for itself left out
  long live_bytes = 0;   ///< handed out and not given back
};

/// Of all threads. Zero where heap_is_counted() is false.
HeapCount heap_count();

/// False under the sanitizers, which have a heap of their own.
bool heap_is_counted();

}  // namespace chasles::test
