#pragma once

#include <chasles/time.hpp>

namespace chasles {

/// Landmarks of the past that were recognised and have returned into a filter.
struct Closure {
  Time time{};        ///< of the frame, on the IMU's clock
  int landmarks = 0;  ///< that returned
  double moved = 0;   ///< by which the frame's update moved the pose [m]
  double turned = 0;  ///< and turned it [rad]
};

}  // namespace chasles
