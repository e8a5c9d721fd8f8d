#pragma once

#include <cmath>

namespace chasles {

inline constexpr double kLossSigmas = 3;  ///< where Huber's loss of a corner's error begins

/// A corner's whitened error of this length: the factor on its rows, and its cost.
struct WeightedCorner {
  double root_weight, cost;
};

inline WeightedCorner weighted_corner(double sigmas) {
  if (sigmas <= kLossSigmas) return {1, sigmas * sigmas / 2};
  return {std::sqrt(kLossSigmas / sigmas), kLossSigmas * (sigmas - kLossSigmas / 2)};
}

}  // namespace chasles
