#include "forks.hpp"

#include <atomic>
#include <string>

#include <chasles/base/error.hpp>

#include "turns.hpp"

namespace chasles::python {
namespace {

namespace py = pybind11;

std::atomic<int> generation = 0;
std::atomic<int> unfit = 0;  // threads of this process that have something half done
bool turn_held = false;      // by the thread that forks, during the fork
bool was_fit = true;         // at the latest fork
std::atomic<bool> cut_off = false;

// With the GIL, so that only one thread of Python is here.
void before() {
  turn_held = estimation().try_lock();
  was_fit = turn_held && unfit == 0;
}

void after_in_parent() {
  if (turn_held) estimation().unlock();
}

void after_in_child() {
  after_in_parent();
  ++generation;
  unfit = 0;
  if (!was_fit) cut_off = true;
}

const std::string kSpawn =
    "; expected a process of its own: multiprocessing.get_context(\"spawn\"), or the fork before "
    "the estimators (docs/python.md)";

}  // namespace

void watch_forks() {
  py::module_::import("os").attr("register_at_fork")(
      py::arg("before") = py::cpp_function(&before),
      py::arg("after_in_parent") = py::cpp_function(&after_in_parent),
      py::arg("after_in_child") = py::cpp_function(&after_in_child));
}

int fork_generation() { return generation; }

UnfitForForks::UnfitForForks() { ++unfit; }
UnfitForForks::~UnfitForForks() { --unfit; }

void reject_after_fork() {
  if (!cut_off) return;
  throw UsageError(
      "this process was forked while an estimator or a reader of its parent worked, and its thread "
      "is not in this process" +
      kSpawn);
}

void reject_thread_of(int made_in, const char* what) {
  if (made_in == generation) return;
  throw UsageError(std::string(what) +
                   ": was made before this process was forked, and its thread is not in this "
                   "process" +
                   kSpawn);
}

}  // namespace chasles::python
