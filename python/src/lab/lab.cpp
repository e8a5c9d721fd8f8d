#include "lab.hpp"

#include <string>
#include <vector>

#include <pybind11/stl.h>

#include "long_call.hpp"
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
  return LongCall(py::none(), LongCall::Bars::kOfCommand).in_turn([&] {
    return app::program(static_cast<int>(pointers.size()) - 1, pointers.data());
  });
}

}  // namespace
}  // namespace chasles::python

PYBIND11_MODULE(_lab, m) {
  using namespace chasles::python;
  m.doc() = "The compiled laboratory of chasles, and the command.";
  bind_simulation(m);
  bind_studies(m);
  m.def("command", &command, pybind11::arg("arguments"),
        "Runs the command `chasles` with these arguments and returns its exit code.");
}
