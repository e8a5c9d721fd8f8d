#pragma once

#include <algorithm>
#include <chrono>

namespace chasles {

/// Limits how often, and for which share of the time, a run works for its viewers.
class Pace {
 public:
  using Clock = std::chrono::steady_clock;
  /// At least `between` from one piece of work to the next, and `share` times what it took.
  Pace(Clock::duration between, int share) : between_(between), share_(share) {}

  bool is_due() const { return Clock::now() >= next_; }
  /// Does the work, and returns its result.
  template <typename Work>
  auto operator()(const Work& work) {
    const Clock::time_point start = Clock::now();
    auto result = work();
    const Clock::time_point end = Clock::now();
    next_ = end + std::max<Clock::duration>(between_, share_ * (end - start));
    return result;
  }

 private:
  Clock::duration between_;
  int share_;
  Clock::time_point next_{};
};

/// Of the map: once per second, for a hundredth of the time.
inline Pace map_pace() { return {std::chrono::seconds(1), 100}; }

}  // namespace chasles
