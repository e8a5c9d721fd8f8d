#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/filter/past/segment.hpp>

namespace chasles {

/// A segment of a run, and the past states that returned when it began: its last starts.
struct Stretch {
  const Segment* segment = nullptr;
  const std::vector<int>* revived = nullptr;
};

struct SmoothedState {
  int number = 0;
  Eigen::VectorXd correction;
  Eigen::MatrixXd covariance;
};

/// What is known exactly has a covariance of zero; what remains of it, and of its correction, are
/// rounding errors.
SmoothedState without_rounding(SmoothedState state);

/// Fixed-interval smoothing: correction and covariance of every item of the segments, given the
/// measurements of all of them, in the order of numbers.
std::vector<SmoothedState> smooth_segments(const std::vector<Stretch>& stretches);

}  // namespace chasles
