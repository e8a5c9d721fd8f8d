#pragma once

#include <vector>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/sim/inertial_world.hpp>

namespace chasles {

/// The output of a tracker without errors.
struct InertialTracks {
  std::vector<FeatureFrame> frames;  ///< one for each pose, sorted by landmark and then by camera
  std::vector<std::size_t>
      points;  ///< for each landmark number the index of its point in the world
};

/// Selects and tracks landmarks. A tracked landmark stays tracked while any camera sees it. If
/// fewer than `landmarks_in_view` remain, new tracks start at visible points of the smallest index,
/// except at points that would be out of view before `shortest_track` frames. Landmarks are
/// numbered in the order of their first frame. A point that comes back into view is a new landmark,
/// unless `keep_ids`. With a rolling shutter a pixel is where the point is seen when its own line
/// is exposed, by the motion after the pose.
InertialTracks follow(const InertialSettings& settings, const InertialWorld& world,
                      const std::vector<Camera>& cameras, const Trajectory& poses,
                      const Spline& motion);

}  // namespace chasles
