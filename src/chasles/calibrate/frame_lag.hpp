#pragma once

#include <map>
#include <optional>

#include <chasles/base/time.hpp>
#include <chasles/lie/se3.hpp>

namespace chasles {

/// One camera's images are so many frames late against another's.
struct FrameLag {
  int frames = 0;      ///< 1: its image shows what the other one saw a frame before
  double seconds = 0;  ///< the median of the time between them
};

/// Compares cam_T_target of two cameras by the stated times: their relative attitude is the same at
/// all instants, and if it is so much better between images up to 3 frames apart, these belong
/// together. None where the stated times are right, or the views too few to show it.
std::optional<FrameLag> frame_lag(const std::map<Time, SE3>& first,
                                  const std::map<Time, SE3>& second);

}  // namespace chasles
