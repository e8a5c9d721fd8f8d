#pragma once

#include <optional>

#include <chasles/base/time.hpp>

namespace chasles {

/// Landmarks of the past that were recognised and have returned into a filter.
struct Closure {
  Time time{};        ///< of the frame, on the IMU's clock
  int landmarks = 0;  ///< that returned
  double moved = 0;   ///< by which the frame's update moved the pose [m]
  double turned = 0;  ///< and turned it [rad]
  /// Later frames rejected most of the landmarks: the filter went on as if they had not returned.
  bool undone = false;
  /// Of the landmarks' innovations before the update, against their joint covariance: chi2 with
  /// `dof` degrees of freedom.
  double square = 0;
  int dof = 0;
};

/// Attempts of a run to find its place in a prior map.
struct PlaceCounts {
  int searches = 0;              ///< for a place by appearance
  int proposed = 0;              ///< places that were found so
  int rejected = 0;              ///< of them, those whose landmarks were not jointly compatible
  std::optional<Time> placed{};  ///< when the place was accepted, on the IMU's clock
};

}  // namespace chasles
