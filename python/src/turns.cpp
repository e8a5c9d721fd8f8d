#include "turns.hpp"

#include <chasles/error.hpp>

namespace chasles::python {
namespace {

// A call may run another one: a chart may evaluate with another chart.
int& depth_of_calls() {
  thread_local int depth = 0;
  return depth;
}

}  // namespace

std::mutex& estimation() {
  static std::mutex mutex;
  return mutex;
}

PythonCall::PythonCall() { ++depth_of_calls(); }

PythonCall::~PythonCall() { --depth_of_calls(); }

bool PythonCall::active() { return depth_of_calls() > 0; }

void refuse_in_call() {
  if (!PythonCall::active()) return;
  throw UsageError(
      "an estimator is used from a chart, a depth rule or a signal handler that an estimator runs: "
      "it would wait for itself for ever. Read what is needed before or after the call");
}

std::unique_lock<std::mutex> take_turn() {
  refuse_in_call();
  return std::unique_lock(estimation());
}

bool Signals::pending() {
  if (raised_) return true;
  const PythonCall call;
  if (PyErr_CheckSignals() != 0) {
    error_ = std::make_unique<pybind11::error_already_set>();
    raised_ = true;
  }
  return raised_;
}

void Signals::rethrow() {
  if (error_) throw pybind11::error_already_set(*error_);
}

}  // namespace chasles::python
