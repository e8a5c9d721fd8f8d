#pragma once

#include <atomic>
#include <cstddef>
#include <exception>
#include <utility>

namespace chasles {

/// Ends a call that another thread has interrupted. It is no Error: nothing may take it for what is
/// wrong with an input.
struct Interrupted : std::exception {
  const char* what() const noexcept override { return "interrupted"; }
};

/// What a thread shows another one of a long call, and what it is asked.
struct CallProgress {
  std::atomic<bool> stop = false;                ///< asked to end
  std::atomic<std::size_t> done = 0, total = 0;  ///< total 0: not known
  bool quiet = false;                            ///< the call itself draws no bar
};

/// While it lives, the calls of this thread show themselves in `progress`.
class ObservedCall {
 public:
  explicit ObservedCall(CallProgress& progress) : before_(std::exchange(current(), &progress)) {}
  ~ObservedCall() { current() = before_; }
  ObservedCall(const ObservedCall&) = delete;
  ObservedCall& operator=(const ObservedCall&) = delete;

  /// Null: nobody observes this thread.
  static CallProgress*& current() {
    thread_local CallProgress* progress = nullptr;
    return progress;
  }

 private:
  CallProgress* before_;
};

/// Whether this thread's call is to draw no bar of its own.
inline bool bars_are_unwanted() {
  const CallProgress* const call = ObservedCall::current();
  return call != nullptr && call->quiet;
}

/// Whether this thread's call is asked to end.
inline bool interruption_wanted() {
  const CallProgress* const call = ObservedCall::current();
  return call != nullptr && call->stop.load(std::memory_order_relaxed);
}

/// Throws Interrupted where this thread's call is asked to end. Loops that take more than a tenth
/// of a second call it; it costs a nanosecond.
inline void interruption_point() {
  if (interruption_wanted()) throw Interrupted();
}

/// The same, in a loop whose length is known.
inline void interruption_point(std::size_t done, std::size_t total) {
  if (CallProgress* const call = ObservedCall::current()) {
    call->done.store(done, std::memory_order_relaxed);
    call->total.store(total, std::memory_order_relaxed);
  }
  interruption_point();
}

}  // namespace chasles
