#include <algorithm>

#include <chasles/check/gyroscope_turns.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {

GyroscopeTurns::GyroscopeTurns(const std::vector<StampedRate>& rates) : rates_(&rates) {
  start_R_.push_back(Eigen::Matrix3d::Identity());
  for (std::size_t i = 1; i < rates.size(); ++i) {
    const double span = to_seconds(rates[i].time - rates[i - 1].time);
    start_R_.push_back(start_R_.back() *
                       so3::exp((rates[i].rate_imu + rates[i - 1].rate_imu) / 2 * span));
  }
}

Eigen::Vector3d GyroscopeTurns::rate(Time time) const {
  const Place p = place(time);
  const StampedRate &a = (*rates_)[p.later - 1], &b = (*rates_)[p.later];
  return a.rate_imu + p.part * (b.rate_imu - a.rate_imu);
}

Eigen::Vector3d GyroscopeTurns::turn(Time begin, Time end) const {
  return so3::log(at_time(begin).transpose() * at_time(end));
}

GyroscopeTurns::Place GyroscopeTurns::place(Time time) const {
  const auto later =
      std::upper_bound(rates_->begin() + 1, rates_->end() - 1, time,
                       [](Time t, const StampedRate& rate) { return t < rate.time; });
  const auto i = static_cast<std::size_t>(later - rates_->begin());
  const double span = to_seconds((*rates_)[i].time - (*rates_)[i - 1].time);
  return {i, span > 0 ? to_seconds(time - (*rates_)[i - 1].time) / span : 0};
}

Eigen::Matrix3d GyroscopeTurns::at_time(Time time) const {
  const Place p = place(time);
  const StampedRate &a = (*rates_)[p.later - 1], &b = (*rates_)[p.later];
  const double span = to_seconds(b.time - a.time) * p.part;
  return start_R_[p.later - 1] *
         so3::exp((a.rate_imu + p.part / 2 * (b.rate_imu - a.rate_imu)) * span);
}

}  // namespace chasles
