#pragma once

#include <optional>
#include <string_view>

#include <Eigen/Core>

#include <chasles/camera/feature_frame.hpp>

namespace chasles {

/// What became of an observation that a filter was offered.
enum class Outcome {
  kWaiting,   ///< its point is not in the state (the filter may come back to it), or all is at rest
  kBegun,     ///< its point came into the state with this frame
  kUsed,      ///< it updated the state
  kRejected,  ///< of a point in the state, but not where that could be
};

const char* name(Outcome outcome);
/// The outcome of that name, if there is one.
std::optional<Outcome> outcome_of(std::string_view name);

/// Where a filter expected a point to be seen.
struct ExpectedPixel {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();       ///< [px]
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of the innovation [px^2]
};

/// An observation, and what the filter made of it.
struct PixelOutcome {
  PixelObservation observation;
  Outcome outcome = Outcome::kWaiting;
  /// Before the update. None where the point is not in the state, or has no projection.
  std::optional<ExpectedPixel> expected = {};
};

}  // namespace chasles
