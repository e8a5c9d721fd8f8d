#pragma once

#include <optional>
#include <vector>

#include <chasles/filter/depth_rule.hpp>
#include <chasles/filter/pixel_measurement.hpp>
#include <chasles/slam/slam_context.hpp>

namespace chasles {

/// Initialises landmarks with their first observation, at an assumed depth.
class UndelayedInitialiser {
 public:
  /// An empty rule: the depth of the settings.
  explicit UndelayedInitialiser(DepthRule rule) : rule_(std::move(rule)) {}

  /// A landmark at the depth that the rule or the settings assume, of inverse depth or Cartesian.
  /// An anchored one needs the present pose as the latest clone. None where the rule waits, or the
  /// lens model has no ray.
  std::optional<NewLandmark> landmark(const SlamContext& x, LandmarkId id, int camera,
                                      const Eigen::Vector2d& pixel, bool anchored) const;
  /// Initialises landmarks of these observations at once, as far as the state has room (Kleinert &
  /// Stilla). Returns their number.
  int initialise(SlamContext& x, const std::vector<const PixelObservation*>& fresh);

 private:
  DepthRule rule_;
  Reused<NewLandmark> landmarks_;
};

}  // namespace chasles
