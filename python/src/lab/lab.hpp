#pragma once

#include <string>

#include <pybind11/pybind11.h>

// The module chasles._lab: simulation, studies and the command. It is linked to the module
// chasles._core, whose classes, turns and registered charts it uses.
namespace chasles::python {

void bind_simulation(pybind11::module_& m);
void bind_studies(pybind11::module_& m);

/// As check_keys() for the settings of a scene. Throws UsageError for an unknown scene, too.
void check_scene_keys(const std::string& function, const std::string& scene,
                      const pybind11::dict& settings);

}  // namespace chasles::python
