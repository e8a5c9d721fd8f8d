#pragma once

#include <optional>
#include <vector>

#include <chasles/slam/dynamic_window.hpp>
#include <chasles/slam/inertial_start.hpp>
#include <chasles/slam/initialiser_settings.hpp>
#include <chasles/slam/requirement.hpp>

namespace chasles {

/// What became of a try: the conditions as far as they could be measured, and the start where all
/// are met.
struct StartAttempt {
  std::vector<Requirement> requirements;
  std::optional<InertialStart> start;
};

/// A start in motion, at the first keyframe of the window: the gyroscope's bias from rotations
/// (gyroscope_bias.hpp), velocity and gravity from linear equations (motion_linear.hpp), then all
/// of it by least squares (motion_refine.hpp). The filter gets the window's data once more, so its
/// covariance is that of the priors and of 1 / inflation of the data's information.
StartAttempt dynamic_start(const MotionWindow& window, const ImuNoise& noise,
                           const InitialiserSettings& settings);

}  // namespace chasles
