#pragma once

#include <optional>
#include <vector>

#include <chasles/estimate/requirement.hpp>
#include <chasles/initialise/dynamic_window.hpp>
#include <chasles/initialise/inertial_start.hpp>
#include <chasles/initialise/initialiser_settings.hpp>

namespace chasles {

/// The result of an attempt: the conditions that could be evaluated, and the start where all are
/// met.
struct StartAttempt {
  std::vector<Requirement> requirements;
  std::optional<InertialStart> start;
};

/// A dynamic initialisation at the first keyframe of the window. The gyroscope bias comes from
/// rotations (gyroscope_bias.hpp), velocity and gravity from linear equations (dynamic_linear.hpp),
/// and the final estimate from least squares (dynamic_refine.hpp). The filter processes the
/// window's data again. Therefore the covariance contains the priors and only 1 / inflation of the
/// data's information.
StartAttempt dynamic_start(const MotionWindow& window, const ImuNoise& noise,
                           const InitialiserSettings& settings);

}  // namespace chasles
