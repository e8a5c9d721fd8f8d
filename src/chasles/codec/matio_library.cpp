#include <dlfcn.h>
#include <string>

#include <chasles/base/error.hpp>
#include <chasles/codec/matio_library.hpp>

namespace chasles {
namespace {

constexpr const char* kFile = CHASLES_MATIO_FILE;  // libmatio.so.11

void* loaded() {
  if (void* library = dlopen(kFile, RTLD_NOW | RTLD_LOCAL)) return library;
  throw InputError(std::string(kFile) +
                   ": cannot be loaded, and .mat files need it: install the package of libmatio (" +
                   dlerror() + ")");
}

template <typename Function>
void find(void* library, const char* name, Function& function) {
  void* address = dlsym(library, name);
  if (address == nullptr) throw InputError(std::string(kFile) + ": has no function " + name);
  function = reinterpret_cast<Function>(address);
}

MatioLibrary load() {
  void* library = loaded();  // until the program ends
  MatioLibrary functions{};
  find(library, "Mat_Open", functions.open);
  find(library, "Mat_Close", functions.close);
  find(library, "Mat_Rewind", functions.rewind);
  find(library, "Mat_VarReadNextInfo", functions.read_next_info);
  find(library, "Mat_VarReadInfo", functions.read_info);
  find(library, "Mat_VarReadDataAll", functions.read_data);
  find(library, "Mat_VarFree", functions.free);
  return functions;
}

}  // namespace

const MatioLibrary& matio() {
  static const MatioLibrary functions = load();
  return functions;
}

}  // namespace chasles
