#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/image_frame.hpp>

namespace chasles {

/// From the images of a camera to those of a pinhole camera of the same size, principal point and
/// focal lengths on the axis. What the camera sees farther out is lost.
class Undistortion {
 public:
  explicit Undistortion(const Camera& camera);

  /// The same camera without distortion.
  const Camera& pinhole() const { return pinhole_; }
  /// Where a pixel of the camera is in its image; none outside of it.
  std::optional<Eigen::Vector2d> pixel(const Eigen::Vector2d& distorted) const;
  /// By bilinear interpolation; black where the camera sees nothing. The image has the camera's
  /// size.
  GrayImage image(const GrayImage& distorted) const;

 private:
  Camera camera_, pinhole_;
  std::vector<Eigen::Vector2f> from_;  ///< of each pixel, its place in the camera's image; or NaN
};

}  // namespace chasles
