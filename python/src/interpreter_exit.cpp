#include "interpreter_exit.hpp"

#include <atomic>
#include <chrono>
#include <thread>
#include <utility>
#include <vector>

namespace chasles::python {
namespace {

namespace py = pybind11;

// Atomic numbers and no mutex: a fork may happen at any time.
std::atomic<bool> ending = false;  // set with the GIL
std::atomic<bool> ended = false;
std::atomic<int> without_gil = 0;  // Released that live, of all threads but those that are held
std::atomic<int> with_gil = 0;     // Held that live
std::atomic<bool> ender_inside = false;

struct OfThread {
  int without_gil = 0, with_gil = 0;
  bool ends = false;  // it ends the interpreter
};
OfThread& of_thread() {
  thread_local OfThread counts;
  return counts;
}

std::vector<std::function<void()>>& tasks() {
  static auto* const all = new std::vector<std::function<void()>>;
  return *all;
}

// Its frames keep what they have. Without the GIL.
[[noreturn]] void hold_for_ever() {
  OfThread& own = of_thread();
  without_gil -= own.without_gil;
  with_gil -= own.with_gil;
  for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
}

// Whether this thread may no more take the GIL. What works for the thread that ends the interpreter
// goes on for ever.
bool is_out() { return ended && !ender_inside && !of_thread().ends; }

// Until when the end waits.
std::chrono::steady_clock::time_point& deadline() {
  static std::chrono::steady_clock::time_point time;
  return time;
}

void at_exit() {
  constexpr std::chrono::seconds kLongest(5);
  constexpr std::chrono::milliseconds kForWhatFollowsACall(50);  // as a `finally` that prints
  deadline() = std::chrono::steady_clock::now() + kLongest;
  of_thread().ends = true;
  ending = true;
  if (without_gil > 0) {
    const py::gil_scoped_release released;
    if (wait_at_exit([] { return without_gil == 0; })) {
      std::this_thread::sleep_for(kForWhatFollowsACall);
    }
  }
  for (const auto& task : tasks()) task();
  ended = true;
  const py::gil_scoped_release released;
  wait_at_exit([] { return with_gil == 0; });
}

// A fork has this thread alone.
void after_fork() {
  const OfThread& own = of_thread();
  without_gil = own.without_gil;
  with_gil = own.with_gil;
}

}  // namespace

Released::Released() : state_(nullptr) {
  OfThread& own = of_thread();
  if (own.with_gil == 0) end_for_exit();
  ++own.without_gil;
  ++without_gil;
  if (own.ends) ender_inside = true;
  state_ = PyEval_SaveThread();
}

Released::~Released() {
  if (is_out()) hold_for_ever();
  PyEval_RestoreThread(state_);
  OfThread& own = of_thread();
  --own.without_gil;
  --without_gil;
  if (own.ends && own.without_gil == 0) ender_inside = false;
}

Held::Counted::Counted() {
  ++of_thread().with_gil;
  ++with_gil;
  // Counted first: the end waits for this thread, or this thread sees the end.
  if (ended && !ender_inside && !of_thread().ends) hold_for_ever();
}
Held::Counted::~Counted() {
  --of_thread().with_gil;
  --with_gil;
}

Held::Held() = default;

bool ends_for_exit() { return ending && !of_thread().ends && !ender_inside; }

void end_for_exit() {
  if (!ends_for_exit()) return;
  PyErr_SetNone(PyExc_SystemExit);
  throw py::error_already_set();
}

void at_exit_also(std::function<void()> task) { tasks().push_back(std::move(task)); }

bool wait_at_exit(const std::function<bool()>& done) {
  constexpr std::chrono::milliseconds kBetweenPolls(2);
  while (!done()) {
    if (std::chrono::steady_clock::now() > deadline()) return false;
    std::this_thread::sleep_for(kBetweenPolls);
  }
  return true;
}

void watch_exit() {
  py::module_::import("atexit").attr("register")(py::cpp_function(&at_exit));
  py::module_::import("os").attr("register_at_fork")(py::arg("after_in_child") =
                                                         py::cpp_function(&after_fork));
}

}  // namespace chasles::python
