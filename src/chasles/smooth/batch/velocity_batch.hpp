#pragma once

#include <vector>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/stereo.hpp>
#include <chasles/slam/velocity_slam.hpp>
#include <chasles/smooth/batch/batch.hpp>

namespace chasles {

/// What batch estimation takes from a recording with body velocities and a rectified stereo pair.
struct VelocityBatchInput {
  StereoRig rig;
  /// The filter's: of them chart, motion model, rows of the measurement, min_disparity and what is
  /// known at the start are taken. Its gates and budgets are not: the batch has its own.
  VelocitySlamSettings settings;
  VelocitySlamNoise noise;
  std::vector<BodyVelocity> velocities;
  std::vector<FeatureFrame> frames;
  /// Where to begin the search, times rising, as the filter's estimates; an instant without one is
  /// predicted from the one before by the velocities. Empty: all of them are.
  std::vector<Estimate> initial = {};
};

struct VelocityBatchResult {
  std::vector<Estimate> estimates;  ///< of all keyframes, given all frames; no NIS
  std::vector<MapLandmark> landmarks;
  BatchReport report;
};

/// The most probable motion and landmarks, all velocities and frames given: as the smooth() of
/// batch.hpp, with the filter's model for body velocities (filter/body_velocity_model.hpp) instead
/// of samples of an IMU. Every instant of a velocity or a keyframe is a pose with its additive
/// states; the world is the pose at the first event. The first look at a landmark counts with its
/// disparity and the noise of VelocitySlamNoise::begin, as in the filter, later ones as
/// VelocitySlamSettings::stereo_rows say.
///
/// Recovered and counted: see BatchReport. Throws InputError where there is nothing to estimate
/// from (fewer than two keyframes, no landmark that is seen twice, no velocities), for velocities
/// that are not finite and time that runs backwards, noise that is zero, and where a position is
/// uncertain by more than 1 m and a tenth of the way; Error(kDiverged) where no finite cost was
/// found; UsageError for settings that cannot be used, and for those that only a filter has (mode
/// other than slam, update_with_first_observation, initial_landmark_sigma).
VelocityBatchResult smooth(const VelocityBatchInput& input, const BatchSettings& settings);

}  // namespace chasles
