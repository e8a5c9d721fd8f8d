#pragma once

#include <string>

#include <chasles/imu/imu_buffer.hpp>

namespace chasles {

/// The report of a window, besides its estimates.
struct WindowReport {
  int window = 0;          ///< its number of keyframes with a frame
  int keyframes = 0;       ///< of the whole run
  int observations = 0;    ///< used ones
  int unusable = 0;        ///< not finite, of an unknown camera, or twice in a frame
  int gated = 0;           ///< rejected by the gate; not among `observations`
  int dropped_frames = 0;  ///< not later than the previous one, or without samples nearby
  int landmarks = 0;       ///< initialised ones
  int steps = 0, steps_rejected = 0;  ///< all steps, and those that did not lower the cost
  int frames_not_converged = 0;       ///< where the last step still lowered the cost
  double covariance_factor = 1;       ///< of the last covariance (ResidualWalk)
  ImuBuffer::Counts imu;
  double seconds = 0;  ///< processor time [s]; differs from run to run
};

/// Adds the counts of another window.
void add(const WindowReport& more, WindowReport& sum);

}  // namespace chasles
