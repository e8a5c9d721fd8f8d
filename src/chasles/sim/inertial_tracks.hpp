#pragma once

#include <vector>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/sim/inertial_world.hpp>

namespace chasles {

/// What a tracker would follow, without any error.
struct InertialTracks {
  std::vector<FeatureFrame> frames;  ///< one for each pose, by landmark and then by camera
  std::vector<std::size_t> points;   ///< of each landmark number: its point of the world
};

/// Chooses and follows landmarks: one that is tracked stays tracked while any camera sees it; where
/// fewer than `landmarks_in_view` are left, visible ones of the least index begin, but none that
/// would be out of sight before `shortest_track` frames. Landmarks are numbered in the order in
/// which they begin; one that comes back is a new landmark, unless `keep_ids`.
InertialTracks follow(const InertialSettings& settings, const InertialWorld& world,
                      const std::vector<Camera>& cameras, const Trajectory& poses);

}  // namespace chasles
