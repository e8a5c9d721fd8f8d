#pragma once

#include <functional>

#include <pybind11/pybind11.h>

// The end of the interpreter while other threads of Python are in a call. Python ends a thread that
// takes the GIL then by unwinding its stack, which aborts the process in frames of C++. So the
// module asks the calls to end before that (atexit), and waits for them. They end with SystemExit,
// which `threading` passes over. Threads that are too late are held for ever, as Python does from
// 3.14 on.
namespace chasles::python {

/// This thread without the GIL, as py::gil_scoped_release. At the end of the interpreter the
/// constructor throws as end_for_exit(). After it, the destructor does not return.
class Released {
 public:
  Released();
  ~Released();
  Released(const Released&) = delete;
  Released& operator=(const Released&) = delete;

 private:
  PyThreadState* state_;
};

/// This thread with the GIL, as py::gil_scoped_acquire. After the end of the interpreter the
/// constructor does not return.
class Held {
 public:
  Held();
  Held(const Held&) = delete;
  Held& operator=(const Held&) = delete;

 private:
  struct Counted {
    Counted();
    ~Counted();
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;
  };
  const Counted counted_;  // outlives the next one
  const pybind11::gil_scoped_acquire held_;
};

/// Whether the interpreter ends, and the call of this thread is to end for it. Any thread.
bool ends_for_exit();

/// Throws SystemExit where ends_for_exit(). With the GIL.
void end_for_exit();

/// Registers the function for `atexit`.
void watch_exit();

/// Called at the end of the interpreter with the GIL, once no other thread is in a call.
void at_exit_also(std::function<void()> task);

/// Waits until `done` or too long has passed; returns whether it is done. Without the GIL.
bool wait_at_exit(const std::function<bool()>& done);

}  // namespace chasles::python
