#include <cstddef>

#include <pybind11/pybind11.h>

#include "module.hpp"

namespace chasles::python {
namespace {

namespace py = pybind11;

// Where an object has no content, pybind11 would allocate some without constructing it.
void* reject(std::size_t) {
  throw py::type_error(
      "the object has no content: it was made by __new__ or copied without __init__; expected one "
      "that a constructor or a function of chasles has returned");
}

}  // namespace

void reject_bare_objects(const py::module_& m) {
  for (const auto& [name, value] : py::dict(m.attr("__dict__"))) {
    if (!PyType_Check(value.ptr())) continue;
    auto* const type = reinterpret_cast<PyTypeObject*>(value.ptr());
    if (py::detail::type_info* const info = py::detail::get_type_info(type)) {
      info->operator_new = &reject;
    }
  }
}

}  // namespace chasles::python
