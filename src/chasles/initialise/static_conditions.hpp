#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/estimate/requirement.hpp>
#include <chasles/imu/imu_sample.hpp>
#include <chasles/initialise/initialiser_settings.hpp>

namespace chasles {

/// Name of the condition that there are enough tracks.
constexpr const char* kTracks = "tracks";

/// Temporary memory of static_conditions, and its result.
struct StandstillScratch {
  /// One observation of a track, in one half of the window.
  struct Observation {
    LandmarkId landmark = 0;
    int camera = 0;
    std::size_t order = 0;  ///< among all observations
    std::size_t half = 0;   ///< 0 or 1
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  };
  std::vector<Observation> observations;
  std::vector<int> frames;     ///< of each camera, in which it observes anything
  std::vector<double> pixels;  ///< displacement of each track between the halves
  std::vector<Requirement> requirements;
};

/// The conditions of a standstill: the samples scatter about their mean as their noise does; the
/// mean rate is a possible bias, and the mean force a possible gravity; and half of the tracks keep
/// their pixels (mean pixel of the second half of the window against that of the first, beyond
/// pixel noise). Conditions after one that is not met are not evaluated. The result is stored in
/// the scratch.
const std::vector<Requirement>& static_conditions(std::span<const ImuSample> samples,
                                                  std::span<const FeatureFrame> frames,
                                                  std::size_t cameras, const ImuNoise& noise,
                                                  double pixel_sigma,
                                                  const InitialiserSettings& settings,
                                                  StandstillScratch& scratch);

}  // namespace chasles
