#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <deque>
#include <mutex>
#include <optional>
#include <utility>

#include <chasles/base/time.hpp>

namespace chasles {

/// The time from the arrival of images until the estimates of their frames. Any thread may call.
class RobotLatency {
 public:
  using Clock = std::chrono::steady_clock;
  /// Since the last take() [s].
  struct Figures {
    double mean = 0, worst = 0;
  };

  void arrived(Time frame, Clock::time_point at) {
    const std::lock_guard lock(mutex_);
    arrivals_.emplace_back(frame, at);
    if (arrivals_.size() > kMostWaiting) arrivals_.pop_front();
  }

  /// An estimate is by the IMU's clock, its frame by that of the cameras: the nearest one.
  void estimated(Time time) {
    const std::lock_guard lock(mutex_);
    const auto distance = [&](const Arrival& arrival) {
      return std::chrono::abs(arrival.first - time);
    };
    const auto nearest = std::ranges::min_element(arrivals_, {}, distance);
    if (nearest == arrivals_.end()) return;
    const double seconds = std::chrono::duration<double>(Clock::now() - nearest->second).count();
    sum_ += seconds;
    worst_ = std::max(worst_, seconds);
    ++count_;
    arrivals_.erase(arrivals_.begin(), nearest + 1);
  }

  /// None: no estimate since the last call.
  std::optional<Figures> take() {
    const std::lock_guard lock(mutex_);
    if (count_ == 0) return std::nullopt;
    const Figures figures{.mean = sum_ / count_, .worst = worst_};
    sum_ = worst_ = 0;
    count_ = 0;
    return figures;
  }

 private:
  using Arrival = std::pair<Time, Clock::time_point>;
  static constexpr std::size_t kMostWaiting = 1000;
  std::mutex mutex_;
  std::deque<Arrival> arrivals_;
  double sum_ = 0, worst_ = 0;
  int count_ = 0;
};

}  // namespace chasles
