#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>

#include <chasles/camera/camera.hpp>
#include <chasles/filter/depth_rule_names.hpp>
#include <chasles/filter/state.hpp>

namespace chasles {

/// A point that is seen for the first time, before its undelayed initialisation.
struct FirstObservation {
  const State& state;    ///< before the initialisation
  const Camera& camera;  ///< as calibrated
  int camera_index = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  bool inverse = false;  ///< whether the landmark has an inverse depth
};

/// Depth along the camera's z axis [m], or inverse depth [1/m], and its standard deviation.
struct AssumedDepth {
  double mean = 0, sigma = 0;
};

/// How deep such a point is assumed to be; none: no landmark begins now. May throw, which ends the
/// run.
using DepthRule = std::function<std::optional<AssumedDepth>(const FirstObservation&)>;

/// Makes the rule known by its name to the setting `depth_rule`, in this process. It replaces an
/// earlier one of the same name for filters that are made from now on. Throws UsageError for the
/// name "constant", for one that is empty or has other characters than letters, digits, '-' and
/// '_', and for an empty function.
void register_depth_rule(std::string name, DepthRule rule);

/// The rule with this name; for "constant" an empty one: that of the settings. Throws UsageError
/// for an unknown name. What the rule returns is checked: UsageError unless mean and sigma are
/// positive and finite.
DepthRule depth_rule(std::string_view name);

}  // namespace chasles
