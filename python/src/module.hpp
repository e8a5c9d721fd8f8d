#pragma once

#include <memory>
#include <vector>

#include <pybind11/pybind11.h>

namespace chasles {
struct BatchTerms;
}

// The parts of the module.
namespace chasles::python {

void bind_errors(pybind11::module_& m);
void bind_recordings(pybind11::module_& m);
void bind_runs(pybind11::module_& m);
void bind_estimates(pybind11::module_& m);
void bind_realtime(pybind11::module_& m);
void bind_slam(pybind11::module_& m);
void bind_imu(pybind11::module_& m);
void bind_evaluation(pybind11::module_& m);
void bind_charts(pybind11::module_& m);
void bind_alignment(pybind11::module_& m);
void bind_checks(pybind11::module_& m);
void bind_noise(pybind11::module_& m);
void bind_calibrations(pybind11::module_& m);
void bind_capture(pybind11::module_& m);
void bind_errors_of_runs(pybind11::module_& m);
void bind_arrays(pybind11::module_& m);

/// Objects of bound classes that `__new__` alone has made have no content: TypeError where they are
/// used. After all classes.
void reject_bare_objects(const pybind11::module_& m);

/// The problems of batch estimation (Estimator::batch_terms) as dictionaries of columns.
pybind11::list problems_of(const std::vector<std::shared_ptr<const BatchTerms>>& parts);

/// Throws ImportError for a numpy with which this module would crash.
void check_numpy();

}  // namespace chasles::python
