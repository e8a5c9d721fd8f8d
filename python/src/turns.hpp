#pragma once

#include <memory>
#include <mutex>

#include <pybind11/pybind11.h>

#include "interpreter_exit.hpp"

// Who may use an estimator when, and the Python code that estimators call.
namespace chasles::python {

/// Estimators of one process take turns: in batch estimation SuiteSparse calls the serial OpenBLAS,
/// which is not reentrant. Locked without the GIL: RealtimeSlam does it on its own thread, others
/// with take_turn().
std::timed_mutex& estimation();

/// While it lives, this thread runs Python code for an estimator: a chart, a depth rule, the
/// handler of a signal. Holds the GIL.
class PythonCall {
 public:
  PythonCall();
  ~PythonCall();
  PythonCall(const PythonCall&) = delete;
  PythonCall& operator=(const PythonCall&) = delete;

  /// Whether this thread is in such a call.
  static bool active();

 private:
  const Held held_;
};

/// Throws UsageError in a PythonCall: its estimator has the turn, so that waiting for one would
/// never end.
void reject_in_call();

/// A turn for this thread. Without the GIL. Throws as reject_in_call() and reject_after_fork(),
/// what the handler of a signal raises meanwhile, and Interrupted.
std::unique_lock<std::timed_mutex> take_turn();

/// The signals of Python, such as Ctrl-C, while this thread waits without the GIL for another one
/// that works for it. Python handles them in its main thread.
class Signals {
 public:
  /// True once a handler has raised, or the interpreter ends.
  bool pending();
  /// Throws what it has raised, if it has. With the GIL.
  void rethrow();

 private:
  std::unique_ptr<pybind11::error_already_set> error_;
};

}  // namespace chasles::python
