#include <string>

#include <pybind11/pybind11.h>

#include "module.hpp"

namespace chasles::python {

namespace py = pybind11;

// pybind11 reads the layout of numpy's types, which numpy 2 has changed: an older pybind11 crashes.
void check_numpy() {
#if PYBIND11_VERSION_MAJOR == 2 && PYBIND11_VERSION_MINOR < 12
  const auto version = py::module_::import("numpy").attr("__version__").cast<std::string>();
  if (std::stoi(version) < 2) return;
  const std::string text =
      "chasles was built with pybind11 " + std::to_string(PYBIND11_VERSION_MAJOR) + "." +
      std::to_string(PYBIND11_VERSION_MINOR) + ", which does not know numpy " + version +
      "; expected numpy 1, or a module built with pybind11 2.12 or later: `pip install .` builds "
      "one (docs/interoperation.md)";
  throw py::import_error(text);
#endif
}

}  // namespace chasles::python
