#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/imu/imu_sample.hpp>
#include <chasles/slam/initialiser_settings.hpp>
#include <chasles/slam/requirement.hpp>

namespace chasles {

/// Name of the condition that there are enough tracks to tell from.
constexpr const char* kTracks = "tracks";

/// What static_conditions writes on the way, and its result.
struct RestScratch {
  /// One look at a track, in one half of the window.
  struct Look {
    LandmarkId landmark = 0;
    int camera = 0;
    std::size_t order = 0;  ///< among all looks
    std::size_t half = 0;   ///< 0 or 1
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  };
  std::vector<Look> looks;
  std::vector<double> pixels;  ///< how far each track moved between the halves
  std::vector<Requirement> requirements;
};

/// Whether nothing moved: the samples deviate from their mean as their noise does, the mean rate
/// can be a bias and the mean force gravity, and half of the tracks stay where they are (the mean
/// pixel of the window's second half against that of the first, beyond pixel noise). What comes
/// after a condition that is not met is not looked at.
/// The result is the scratch's.
const std::vector<Requirement>& static_conditions(std::span<const ImuSample> samples,
                                                  std::span<const FeatureFrame> frames,
                                                  std::size_t cameras, const ImuNoise& noise,
                                                  double pixel_sigma,
                                                  const InitialiserSettings& settings,
                                                  RestScratch& scratch);

}  // namespace chasles
