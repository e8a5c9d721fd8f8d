#pragma once

#include <cstddef>

namespace chasles::test {

/// Heap use of the process by all allocators (operator new, Eigen, C).
struct HeapCount {
  long allocations = 0;  ///< calls so far, without those of OpenBLAS
  long live_bytes = 0;   ///< allocated and not freed
};

/// Counts of all threads. Zero if heap_is_counted() is false.
HeapCount heap_count();

/// False with the sanitizers, which replace the heap.
bool heap_is_counted();

}  // namespace chasles::test
