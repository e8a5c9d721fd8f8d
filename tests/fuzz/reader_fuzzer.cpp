#include <cstdio>
#include <cstdlib>

#include <chasles/base/error.hpp>

#include "kinds.hpp"

namespace {

chasles::fuzz::Kind chosen_kind() {
  const char* name = std::getenv("CHASLES_FUZZ_KIND");
  for (const chasles::fuzz::Kind& one : chasles::fuzz::kinds()) {
    if (name != nullptr && one.name == name) return one;
  }
  std::fputs("expected CHASLES_FUZZ_KIND to be one of the folders that write_seeds makes\n",
             stderr);
  std::exit(1);
}

}  // namespace

// libFuzzer's entry point: the reader of the kind that the environment names.
extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  static const chasles::fuzz::Kind kind = chosen_kind();
  static const std::filesystem::path scratch = chasles::fuzz::make_scratch();
  try {
    kind.read(scratch, {reinterpret_cast<const char*>(data), size});
  } catch (const chasles::InputError&) {
    // The correct response to malformed bytes.
  }
  return 0;
}
