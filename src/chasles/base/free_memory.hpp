#pragma once

#include <cstdlib>

#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace chasles {

/// Gives memory that nobody uses back to the system. The heap keeps the pages of many small blocks
/// that were freed, while large ones that come later get pages of their own. Takes milliseconds.
inline void return_free_memory() {
#ifdef __GLIBC__
  ::malloc_trim(0);
#endif
}

}  // namespace chasles
