#pragma once

#include <cstddef>
#include <deque>

#include <Eigen/Core>

namespace chasles {

/// The gyroscope biases that the front end uses: for an image that of the estimator kLead images
/// before. So the front end may be that far ahead of the estimator, and the frames are the same
/// bytes whether it is or not.
class DelayedBias {
 public:
  static constexpr std::size_t kLead = 3;

  /// Whether the bias for the next image is known.
  bool known() const { return !biases_.empty(); }
  /// That bias [rad/s]: zero for the first kLead images.
  const Eigen::Vector3d& next() const { return biases_.front(); }
  /// The front end has taken an image.
  void pass() { biases_.pop_front(); }
  /// The estimator has taken a frame, and has this bias.
  void note(const Eigen::Vector3d& bias) { biases_.push_back(bias); }

 private:
  std::deque<Eigen::Vector3d> biases_ = std::deque<Eigen::Vector3d>(kLead, Eigen::Vector3d::Zero());
};

}  // namespace chasles
