#include "heap_count.hpp"

#include <atomic>
#include <cerrno>
#include <malloc.h>

#if !defined(__SANITIZE_ADDRESS__) && defined(__GLIBC__)
#define CHASLES_COUNTS_HEAP 1
#else
#define CHASLES_COUNTS_HEAP 0
#endif

namespace chasles::test {
namespace {

std::atomic<long> allocations = 0, live_bytes = 0;

#if CHASLES_COUNTS_HEAP
void* note(void* p) {
  if (!p) return p;
  allocations.fetch_add(1, std::memory_order_relaxed);
  live_bytes.fetch_add(static_cast<long>(::malloc_usable_size(p)), std::memory_order_relaxed);
  return p;
}

void forget(void* p) {
  if (p) {
    live_bytes.fetch_sub(static_cast<long>(::malloc_usable_size(p)), std::memory_order_relaxed);
  }
}
#endif

}  // namespace

HeapCount heap_count() { return {.allocations = allocations, .live_bytes = live_bytes}; }
bool heap_is_counted() { return CHASLES_COUNTS_HEAP == 1; }

}  // namespace chasles::test

#if CHASLES_COUNTS_HEAP
// glibc's own, behind the names that everything else calls.
using chasles::test::forget;
using chasles::test::note;

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) { return note(__libc_malloc(size)); }
void* calloc(std::size_t count, std::size_t size) { return note(__libc_calloc(count, size)); }
void* realloc(void* old, std::size_t size) {
  forget(old);
  return note(__libc_realloc(old, size));
}
void* memalign(std::size_t alignment, std::size_t size) {
  return note(__libc_memalign(alignment, size));
}
void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }
int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
  *result = memalign(alignment, size);
  return *result ? 0 : ENOMEM;
}
void free(void* p) {
  forget(p);
  __libc_free(p);
}
}
#endif
