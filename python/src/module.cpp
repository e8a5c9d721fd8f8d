#include "module.hpp"

#include <string>

#include <chasles/base/error.hpp>

#include "forks.hpp"
#include "interpreter_exit.hpp"
#include "messages.hpp"

namespace chasles::python {

namespace {

namespace py = pybind11;

// For PyErr_SetString. Never freed: exceptions may outlive the module.
struct Errors {
  py::object error, usage, input, not_initialised, diverged;
};
Errors& errors() {
  static auto* const all = new Errors;
  return *all;
}

py::object new_error(py::module_& m, const char* name, const py::handle& bases, const char* doc) {
  const std::string full = std::string("chasles.") + name;
  auto type = py::reinterpret_steal<py::object>(
      PyErr_NewExceptionWithDoc(full.c_str(), doc, bases.ptr(), nullptr));
  m.attr(name) = type;
  return type;
}

PyObject* type_of(ExitCode code) {
  switch (code) {
    case ExitCode::kUsage:
      return errors().usage.ptr();
    case ExitCode::kBadInput:
      return errors().input.ptr();
    case ExitCode::kNotInitialised:
      return errors().not_initialised.ptr();
    case ExitCode::kDiverged:
      return errors().diverged.ptr();
    default:
      return errors().error.ptr();
  }
}

}  // namespace

void bind_errors(py::module_& m) {
  Errors& e = errors();
  e.error = new_error(m, "Error", PyExc_RuntimeError,
                      "What the command ends with; the others are kinds of it. `run`: the Run "
                      "whose map could not be saved, or None.");
  e.error.attr("run") = py::none();
  const py::tuple of_values = py::make_tuple(e.error, py::handle(PyExc_ValueError));
  e.usage = new_error(m, "UsageError", of_values,
                      "A setting or an argument that cannot be used (exit code 1 of the command).");
  e.input = new_error(m, "InputError", of_values,
                      "A file, a recording or arrays that cannot be used (exit code 2).");
  e.not_initialised = new_error(m, "NotInitialisedError", e.error,
                                "The estimator could not start; the message has the conditions "
                                "that are not met (exit code 3).");
  e.diverged = new_error(m, "DivergedError", e.error,
                         "The estimate is no longer finite or plausible (exit code 4).");
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& error) {
      PyErr_SetString(type_of(error.code()), in_python(error.what()).c_str());
    }
  });
}

}  // namespace chasles::python

PYBIND11_MODULE(_core, m) {
  using namespace chasles::python;
  check_numpy();
  m.doc() = "The compiled part of chasles, without the laboratory.";
  m.attr("__version__") = CHASLES_VERSION;
  bind_errors(m);
  bind_recordings(m);
  bind_runs(m);
  bind_estimates(m);
  bind_realtime(m);
  bind_slam(m);
  bind_imu(m);
  bind_evaluation(m);
  bind_charts(m);
  bind_alignment(m);
  bind_checks(m);
  bind_noise(m);
  bind_calibrations(m);
  bind_capture(m);
  bind_errors_of_runs(m);
  bind_arrays(m);
  reject_bare_objects(m);
  watch_forks();
  watch_exit();
  m.def("in_python", &in_python, pybind11::arg("message"));
}
