#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/check/check_rotation.hpp>

namespace chasles {

/// The rotation that a gyroscope measures, from its first sample on: its rate is linear between two
/// samples. `rates`: at least two, in order of time; they must outlive this.
class GyroscopeTurns {
 public:
  explicit GyroscopeTurns(const std::vector<StampedRate>& rates);

  bool covers(Time time) const {
    return time >= rates_->front().time && time <= rates_->back().time;
  }
  Eigen::Vector3d rate(Time time) const;  ///< [rad/s]
  /// The rotation vector from `begin` to `end`, in IMU axes [rad].
  Eigen::Vector3d turn(Time begin, Time end) const;

 private:
  struct Place {
    std::size_t later;
    double part;
  };
  Place place(Time time) const;
  Eigen::Matrix3d at_time(Time time) const;

  const std::vector<StampedRate>* rates_;
  std::vector<Eigen::Matrix3d> start_R_;
};

}  // namespace chasles
