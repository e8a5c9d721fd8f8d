#pragma once

#include <optional>
#include <string>
#include <vector>

#include <chasles/lie/trajectory.hpp>

namespace chasles {

/// A frame on the body whose pose is known, as a camera's.
struct KnownFrame {
  std::string name;  ///< "cam0"
  SE3 imu_T_frame;
};

/// What a truth is examined with: an estimate, or the integrated rates of a gyroscope.
struct TruthReference {
  std::string name;                ///< "the estimate", "the gyroscope"
  Trajectory poses;                ///< world_T_imu
  bool positions = true;           ///< false: rotations alone, and every position is zero
  bool biased = false;             ///< the rotations drift at a constant rate
  std::optional<bool> level = {};  ///< whether the z axis of its world is vertical; none: unknown
  std::vector<KnownFrame> frames = {};  ///< of which the poses may be
};

}  // namespace chasles
