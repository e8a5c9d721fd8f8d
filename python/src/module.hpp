#pragma once

#include <mutex>

#include <pybind11/pybind11.h>

// The parts of the module.
namespace chasles::python {

/// Estimators of one process take turns: in batch estimation SuiteSparse calls the serial OpenBLAS,
/// which is not reentrant. To be locked without the GIL.
std::mutex& estimation();

void bind_errors(pybind11::module_& m);
void bind_recordings(pybind11::module_& m);
void bind_runs(pybind11::module_& m);
void bind_slam(pybind11::module_& m);
void bind_evaluation(pybind11::module_& m);
void bind_lab(pybind11::module_& m);
void bind_studies(pybind11::module_& m);

}  // namespace chasles::python
