#pragma once

#include <optional>
#include <span>

#include <chasles/smooth/window/window_detail.hpp>

namespace chasles::smooth_detail {

/// The views of a landmark by known cameras at the present values. Poses and anchor move a pixel
/// only through the point of the world, p - w p_imu, so that second derivatives are summed by
/// that, and are turned into those by the poses once for each keyframe.
class PixelViews {
 public:
  PixelViews(const Window& window, const WindowPoint& point);
  /// Adds views, sorted by keyframe, and sets their norms.
  void add(std::span<WindowView> views, PointLinear& linear) const;
  /// Whitened: prediction minus measurement.
  Eigen::Vector2d residual(const WindowView& view) const;

 private:
  std::optional<Seen> see(const WindowView& view) const;

  const Window* window_;
  int own_;  // keyframe of the anchor, whose views depend on no pose
  HomogeneousPoint at_;
  Eigen::Matrix3d by_parameters_ = Eigen::Matrix3d::Identity();
  Eigen::Vector3d from_anchor_ = Eigen::Vector3d::Zero();
};

}  // namespace chasles::smooth_detail
