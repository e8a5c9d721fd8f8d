#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include <chasles/time.hpp>

namespace chasles {

/// Identifies a landmark: the same physical point has the same number in every frame.
using LandmarkId = std::int64_t;

/// Observation of a landmark by a rectified stereo pair: pixels (uL, vL, uR, vR).
struct StereoObservation {
  LandmarkId landmark = 0;
  Eigen::Vector4d pixels = Eigen::Vector4d::Zero();
};

/// Observation of a landmark by one camera of a rig.
struct PixelObservation {
  LandmarkId landmark = 0;
  int camera = 0;                                   ///< index into the rig
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< in the image, not undistorted [px]
};

/// All observations of the cameras at one instant: the input of the filter. A frame may be empty.
struct FeatureFrame {
  Time time{};
  std::vector<StereoObservation> observations = {};  ///< of a rectified pair
  std::vector<PixelObservation> pixels = {};         ///< of single cameras
};

}  // namespace chasles
