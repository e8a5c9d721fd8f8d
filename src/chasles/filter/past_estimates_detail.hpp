#pragma once

#include <vector>

#include <Eigen/Core>

#include <chasles/filter/segment.hpp>

/// Estimates of all past states from the segments of a run. Private to this folder.
namespace chasles::filter_detail {

/// A segment, and the past states that returned when it began: its last starts.
struct Stretch {
  const Segment* segment = nullptr;
  const std::vector<int>* revived = nullptr;
};

struct Smoothed {
  int number = 0;
  Eigen::VectorXd correction;
  Eigen::MatrixXd covariance;
};

/// Correction and covariance of every item, given all measurements, in the order of numbers.
std::vector<Smoothed> smooth(const std::vector<Stretch>& stretches);

}  // namespace chasles::filter_detail
