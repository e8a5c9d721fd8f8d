#pragma once

#include <span>
#include <vector>

#include <chasles/reconstruct/colmap_settings.hpp>
#include <chasles/reconstruct/track_again.hpp>
#include <chasles/viewers/colmap.hpp>

namespace chasles {

/// The images of a keyframe, with their pose.
struct PosedTracks {
  const TrackedImages* images = nullptr;
  SE3 world_T_imu;
};

/// The points of the tracks, and where the images of the keyframes show them.
struct SparsePoints {
  /// An observation: keyframe, camera and pixel.
  struct Observation {
    std::size_t keyframe = 0, camera = 0;
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
    std::size_t point = 0;
  };
  std::vector<ColmapPoint> points;
  std::vector<Observation> observations;  ///< in the order of the points

  /// Tracks that are no point: with too few observations; without a point that all of their images
  /// have in front of them at enough parallax; with too large an error.
  std::size_t too_short = 0, too_uncertain = 0, too_wrong = 0;
};

/// Triangulates every track over the keyframes (triangulate()), in the order of their ids.
/// Observations 90 degrees or more from the axis of a camera are left out: COLMAP has none.
SparsePoints sparse_points(std::span<const PosedTracks> keyframes,
                           const std::vector<Camera>& cameras, const ColmapSettings& settings);

}  // namespace chasles
