#include "turns.hpp"

#include <chrono>

#include <chasles/base/error.hpp>
#include <chasles/base/interruption.hpp>

#include "forks.hpp"

namespace chasles::python {
namespace {

// A call may run another one: a chart may evaluate with another chart.
int& depth_of_calls() {
  thread_local int depth = 0;
  return depth;
}

}  // namespace

std::timed_mutex& estimation() {
  static std::timed_mutex mutex;
  return mutex;
}

PythonCall::PythonCall() { ++depth_of_calls(); }

PythonCall::~PythonCall() { --depth_of_calls(); }

bool PythonCall::active() { return depth_of_calls() > 0; }

void reject_in_call() {
  if (!PythonCall::active()) return;
  throw UsageError(
      "an estimator is used from a chart, a depth rule or a signal handler that an estimator runs: "
      "it would wait for itself for ever. Read what is needed before or after the call");
}

std::unique_lock<std::timed_mutex> take_turn() {
  constexpr std::chrono::milliseconds kBetweenSignals(50);
  reject_in_call();
  reject_after_fork();
  std::unique_lock turn(estimation(), std::defer_lock);
  while (!turn.try_lock_for(kBetweenSignals)) {
    interruption_point();
    if (ends_for_exit()) throw Interrupted();
    const PythonCall call;
    if (PyErr_CheckSignals() != 0) throw pybind11::error_already_set();
  }
  return turn;
}

bool Signals::pending() {
  if (error_ || ends_for_exit()) return true;
  const PythonCall call;
  if (PyErr_CheckSignals() != 0) error_ = std::make_unique<pybind11::error_already_set>();
  return error_ != nullptr;
}

void Signals::rethrow() {
  if (error_) throw pybind11::error_already_set(*error_);
}

}  // namespace chasles::python
