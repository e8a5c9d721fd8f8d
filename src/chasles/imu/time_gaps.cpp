#include <utility>

#include <chasles/imu/time_gaps.hpp>

namespace chasles {

std::optional<TimeGaps::Gap> TimeGaps::add(Time time) {
  if (!last_) {
    last_ = time;
    return std::nullopt;
  }
  if (time <= *last_) return std::nullopt;
  const Time last = std::exchange(*last_, time);
  if (time - last <= kLongest) return std::nullopt;
  return Gap{.last = last, .next = time};
}

}  // namespace chasles
