#pragma once

#include <cstdint>
#include <string>

#include <chasles/lab/trial.hpp>

namespace chasles {

/// The simulation of Zhang, Wu, Song, Huang & Dissanayake, "Convergence and consistency analysis
/// for a 3-D invariant-EKF SLAM" (RA-L 2017, §VI), as far as it is described: a robot that drives
/// in loops, knows its own motion by odometry and sees points in its own axes. Its published NEES
/// are an outside check of the error charts.
struct LoopsSettings {
  int steps = 500;
  int loops = 8;
  double radius = 80;                         ///< of a loop [m]
  double undulation = 1;                      ///< up and down, twice a loop [m]
  int landmarks = 300;                        ///< around the loop
  double range = 20;                          ///< a point is seen nearer than this [m]
  double field_of_view = 2.0943951023931953;  ///< full angle about the x axis [rad]: 120 degrees
  double sigma = 0.01;  ///< noise of every component of odometry and points, relative to it
  std::uint64_t seed = 1;
};

/// One run: the filter starts at the truth with no uncertainty. Position error, attitude error and
/// NEES at every step; the noise of a run is the same for every chart.
Trial run_loops(const LoopsSettings& settings, const std::string& chart, std::uint64_t run);

}  // namespace chasles
