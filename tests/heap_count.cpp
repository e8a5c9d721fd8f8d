#include "heap_count.hpp"

#include <atomic>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <link.h>
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
// Address range of a library's code.
struct Range {
  std::uintptr_t begin = 0, end = 0;
  bool holds(const void* address) const {
    const auto a = reinterpret_cast<std::uintptr_t>(address);
    return a >= begin && a < end;
  }
};

// On processors with AVX-512 OpenBLAS takes a few bytes from the heap for the edges of some small
// products, and frees them before it returns. These calls are not counted.
Range find_openblas() {
  Range found;
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* data) {
        if (!std::strstr(info->dlpi_name, "libopenblas")) return 0;
        for (int i = 0; i < info->dlpi_phnum; ++i) {
          const auto& segment = info->dlpi_phdr[i];
          if (segment.p_type != PT_LOAD || (segment.p_flags & PF_X) == 0) continue;
          auto& range = *static_cast<Range*>(data);
          range.begin = info->dlpi_addr + segment.p_vaddr;
          range.end = range.begin + segment.p_memsz;
        }
        return 1;
      },
      &found);
  return found;
}

// Constant-initialised, because the heap is used before any other initialisation.
Range openblas;
[[gnu::constructor]] void search_openblas() { openblas = find_openblas(); }

void* note(void* p, const void* caller) {
  if (!p) return p;
  if (!openblas.holds(caller)) allocations.fetch_add(1, std::memory_order_relaxed);
  live_bytes.fetch_add(static_cast<long>(::malloc_usable_size(p)), std::memory_order_relaxed);
  return p;
}

void unregister(void* p) {
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
// glibc's own functions, behind the names that all callers use.
using chasles::test::note;
using chasles::test::unregister;

extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t size) { return note(__libc_malloc(size), __builtin_return_address(0)); }
void* calloc(std::size_t count, std::size_t size) {
  return note(__libc_calloc(count, size), __builtin_return_address(0));
}
void* realloc(void* old, std::size_t size) {
  unregister(old);
  return note(__libc_realloc(old, size), __builtin_return_address(0));
}
void* memalign(std::size_t alignment, std::size_t size) {
  return note(__libc_memalign(alignment, size), __builtin_return_address(0));
}
void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }
int posix_memalign(void** result, std::size_t alignment, std::size_t size) {
  *result = memalign(alignment, size);
  return *result ? 0 : ENOMEM;
}
void free(void* p) {
  unregister(p);
  __libc_free(p);
}
}
#endif
