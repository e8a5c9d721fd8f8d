#pragma once

#include <optional>
#include <string_view>

#include <Eigen/Core>

#include <chasles/camera/feature_frame.hpp>

namespace chasles {

/// What the filter did with an observation.
enum class Outcome {
  kWaiting,      ///< its point is not in the state (the filter may use it later), or there is a
                 ///< standstill
  kInitialised,  ///< its landmark was initialised in this frame
  kUsed,         ///< it updated the state
  kRejected,     ///< its landmark is in the state, but the observation was not accepted
};

const char* name(Outcome outcome);
/// The outcome with this name; none for an unknown name.
std::optional<Outcome> outcome_of(std::string_view name);

/// Predicted pixel of a landmark.
struct ExpectedPixel {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();       ///< [px]
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< of the innovation [px^2]
};

/// An observation and its outcome.
struct PixelOutcome {
  PixelObservation observation;
  Outcome outcome = Outcome::kWaiting;
  /// Prediction before the update. None if the point is not in the state, or has no projection.
  std::optional<ExpectedPixel> expected = {};
};

}  // namespace chasles
