#pragma once

#include <pybind11/pybind11.h>

#include <chasles/session/settings_io.hpp>

namespace chasles::python {

/// {name: {"default", "unit", "meaning", "type"}}; the type as Python's annotations have it.
pybind11::dict table_of(const SettingList& settings);

}  // namespace chasles::python
