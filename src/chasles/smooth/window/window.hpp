#pragma once

#include <string>

#include <chasles/imu/imu_buffer.hpp>

namespace chasles {

/// What a window did, besides its estimates.
struct WindowReport {
  int window = 0;                    ///< keyframes with a frame that it holds
  int keyframes = 0;                 ///< of the whole run
  int observations = 0;              ///< that were used
  int unusable = 0;                  ///< not finite, of an unknown camera, or twice in a frame
  int gated = 0;                     ///< left out by the gate; not among `observations`
  int dropped_frames = 0;            ///< not later than the one before, or without samples near
  int landmarks = 0;                 ///< that began
  int steps = 0, steps_refused = 0;  ///< that were tried, and of those that did not lower the cost
  int frames_not_converged = 0;      ///< where the last step still lowered it
  ImuBuffer::Counts imu;
  double seconds = 0;  ///< of the processor; differ from run to run
};

}  // namespace chasles
