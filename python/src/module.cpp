#include "module.hpp"

#include <string>
#include <vector>

#include <pybind11/stl.h>

#include <chasles/error.hpp>

#include "program.hpp"

namespace chasles::python {
namespace {

namespace py = pybind11;

// The command's main function.
int command(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "chasles");
  std::vector<char*> pointers;
  for (std::string& argument : arguments) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  const py::gil_scoped_release released;
  return app::program(static_cast<int>(arguments.size()), pointers.data());
}

}  // namespace

void bind_errors(py::module_& m) {
  static const py::exception<Error> error(m, "Error", PyExc_RuntimeError);
  const py::tuple values = py::make_tuple(error, py::handle(PyExc_ValueError));
  static const py::exception<UsageError> usage(m, "UsageError", values);
  static const py::exception<InputError> input(m, "InputError", values);
  static const py::exception<Error> not_initialised(m, "NotInitialisedError", error.ptr());
  static const py::exception<Error> diverged(m, "DivergedError", error.ptr());
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const Error& e) {
      switch (e.code()) {
        case ExitCode::kUsage: usage(e.what()); break;
        case ExitCode::kBadInput: input(e.what()); break;
        case ExitCode::kNotInitialised: not_initialised(e.what()); break;
        case ExitCode::kDiverged: diverged(e.what()); break;
        default: error(e.what());
      }
    }
  });
}

}  // namespace chasles::python

PYBIND11_MODULE(_core, m) {
  using namespace chasles::python;
  m.doc() = "The compiled part of chasles.";
  m.attr("__version__") = CHASLES_VERSION;
  bind_errors(m);
  bind_recordings(m);
  bind_runs(m);
  bind_slam(m);
  bind_evaluation(m);
  m.def("command", &command, pybind11::arg("arguments"),
        "Runs the command `chasles` with these arguments and returns its exit code.");
}
