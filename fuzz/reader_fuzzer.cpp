#include <cstdlib>

#include <chasles/error.hpp>

#include "kinds.hpp"

// libFuzzer's entry into the reader CHASLES_FUZZ_KIND.
extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  static const chasles::fuzz::Kind* const kind = [] {
    for (const auto& one : chasles::fuzz::kinds()) {
      if (one.name == CHASLES_FUZZ_KIND) return &one;
    }
    std::abort();
  }();
  static const std::filesystem::path scratch = chasles::fuzz::make_scratch();
  try {
    kind->read(scratch, {reinterpret_cast<const char*>(data), size});
  } catch (const chasles::InputError&) {
    // The right answer to malformed bytes.
  }
  return 0;
}
