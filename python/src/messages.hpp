#pragma once

#include <string>
#include <vector>

#include <pybind11/pybind11.h>

// What messages of the libraries and of the command say in Python.
namespace chasles::python {

/// The message with Python's arguments instead of the command's options: `--save-map` is
/// save_map, `--stop 5` is stop=5, and the `--help` of settings is chasles.settings().
std::string in_python(const std::string& message);

/// The names of all settings: of runs with an IMU and with body velocities, and of the reader.
std::vector<std::string> setting_names();

/// Throws UsageError for a key of the arguments that is neither among `own` nor a setting, with the
/// nearest name that is. A dictionary is a prefix.
void check_keys(const std::string& function, const pybind11::dict& arguments,
                const std::vector<std::string>& own);

}  // namespace chasles::python
