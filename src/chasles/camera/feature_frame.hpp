#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <chasles/time.hpp>

namespace chasles {

/// Names a landmark: the same physical point has the same number in every frame that sees it.
using LandmarkId = std::int64_t;

/// One landmark seen by a rectified stereo pair: pixels (uL, vL, uR, vR).
struct StereoObservation {
  LandmarkId landmark = 0;
  Eigen::Vector4d pixels = Eigen::Vector4d::Zero();
};

/// One landmark seen by one camera of a rig.
struct PixelObservation {
  LandmarkId landmark = 0;
  int camera = 0;                                   ///< index into the rig
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< as in the image, not undistorted
};

/// All that the cameras saw at one instant, as numbered points: what the filter takes instead of
/// images. An empty frame is a valid one.
struct FeatureFrame {
  Time time{};
  std::vector<StereoObservation> observations = {};  ///< of a rectified pair
  std::vector<PixelObservation> pixels = {};         ///< of single cameras
};

}  // namespace chasles
