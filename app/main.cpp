#include <cstdlib>

#if defined(__GLIBC__)
#include <malloc.h>
#endif

#include "program.hpp"

namespace {

// Every frame allocates and frees images. By default glibc gives their memory back to the system
// each time, which then clears the same pages again (docs/benchmarks.md).
void keep_freed_memory() {
#if defined(__GLIBC__)
  constexpr int kBytes = 64 << 20;
  mallopt(M_MMAP_THRESHOLD, kBytes / 2);
  mallopt(M_TRIM_THRESHOLD, kBytes);
#endif
}

}  // namespace

int main(int argc, char** argv) {
  keep_freed_memory();
  return chasles::app::program(argc, argv);
}
