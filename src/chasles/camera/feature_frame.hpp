#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/base/time.hpp>
#include <chasles/camera/image_frame.hpp>

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
  int camera = 0;  ///< index into the rig
  /// Whether another camera found the track and this one matched it; none: not known.
  std::optional<bool> match = {};
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< in the image, not undistorted [px]

  /// A track of unknown origin counts as found by camera 0.
  bool is_match() const { return match.value_or(camera > 0); }
};

// A long recording has many millions of them.
static_assert(sizeof(PixelObservation) == 32);

/// All observations of the cameras at one instant: the input of the filter. A frame may be empty.
struct FeatureFrame {
  Time time{};
  std::vector<StereoObservation> observations = {};  ///< of a rectified pair
  std::vector<PixelObservation> pixels = {};         ///< of single cameras
  std::shared_ptr<const ImageFrame> images = {};     ///< in which they were found, if at hand
};

/// A frame to be kept: images need far more memory than observations.
inline FeatureFrame without_images(FeatureFrame frame) {
  frame.images.reset();
  return frame;
}

/// A set of cameras, one bit each. Cameras from 31 on share the last bit.
using CameraSet = std::uint32_t;
inline constexpr int kCameraBits = 32;
inline CameraSet camera_bit(int camera) {
  return CameraSet{1} << static_cast<unsigned>(std::clamp(camera, 0, kCameraBits - 1));
}

/// The cameras that observe anything in this frame. One that does not may have had no image: that
/// it does not observe a landmark says nothing about the landmark.
inline CameraSet observing(const FeatureFrame& frame) {
  CameraSet cameras = 0;
  for (const PixelObservation& o : frame.pixels) cameras |= camera_bit(o.camera);
  return cameras;
}

}  // namespace chasles
