#include "long_call.hpp"

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <thread>

#include "forks.hpp"
#include "interpreter_exit.hpp"

namespace chasles::python {

namespace py = pybind11;

// Signals, then the bar. What either raises ends the work.
void LongCall::poll() {
  if (ends_for_exit()) {
    state_.stop = true;
    return;
  }
  const PythonCall call;
  if (raised_) return;
  try {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!progress_.is_none()) progress_(state_.done.load(), state_.total.load());
  } catch (py::error_already_set& error) {
    raised_ = std::make_unique<py::error_already_set>(error);
    state_.stop = true;
  }
}

void LongCall::watch(const std::function<void()>& work) {
  constexpr std::chrono::milliseconds kBetweenPolls(50);
  std::exception_ptr failure;
  {
    const Released released;
    std::mutex mutex;
    std::condition_variable ended;
    bool done = false;
    std::thread worker([&] {
      {
        const ObservedCall observed(state_);
        const UnfitForForks unfit;
        try {
          work();
        } catch (...) {
          failure = std::current_exception();
        }
      }
      const std::lock_guard lock(mutex);
      done = true;
      ended.notify_all();
    });
    std::unique_lock lock(mutex);
    while (!ended.wait_for(lock, kBetweenPolls, [&] { return done; })) {
      lock.unlock();
      poll();
      lock.lock();
    }
    lock.unlock();
    worker.join();
  }
  if (raised_) throw py::error_already_set(*raised_);
  end_for_exit();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace chasles::python
