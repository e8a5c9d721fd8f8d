#pragma once

#include <vector>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/stereo.hpp>
#include <chasles/smooth/batch/batch.hpp>
#include <chasles/velocity/velocity_slam.hpp>

namespace chasles {

/// The input of batch estimation from a recording with body velocities and a rectified stereo pair.
struct VelocityBatchInput {
  StereoRig rig;
  /// The settings of the filter. Used are chart, motion model, rows of the measurement,
  /// min_disparity and the prior at the start. Not used are its gates and budgets: the batch has
  /// its own.
  VelocitySlamSettings settings;
  VelocitySlamNoise noise;
  std::vector<BodyVelocity> velocities;
  std::vector<FeatureFrame> frames;
  /// Initial states of the search, in order of time, for example the filter's estimates. An instant
  /// without one is predicted from the previous one by the velocities. Empty: all of them are
  /// predicted.
  std::vector<Estimate> initial = {};
};

struct VelocityBatchResult {
  std::vector<Estimate> estimates;  ///< of all keyframes, from all frames; no NIS
  std::vector<MapLandmark> landmarks;
  BatchReport report;
};

/// Throws UsageError for settings that only a filter has: mode other than slam,
/// update_with_first_observation, initial_landmark_sigma.
void check_smoothing(const VelocitySlamSettings& settings);

/// The most probable motion and landmarks for all velocities and frames: as smooth() of batch.hpp,
/// with the filter's model for body velocities (velocity/body_velocity_model.hpp) instead of IMU
/// samples. Every instant of a velocity or a keyframe has a pose and additive states. The world is
/// the pose at the first event. As in the filter, the first observation of a landmark counts with
/// its disparity and the noise VelocitySlamNoise::begin, later ones with the rows of
/// VelocitySlamSettings::stereo_rows.
///
/// Recovered and counted: see BatchReport. Throws InputError for insufficient data (fewer than two
/// keyframes, no landmark that is observed twice, no velocities), for velocities that are not
/// finite, time that runs backwards and noise that is zero, and where a position has a sigma above
/// 1 m and a tenth of the distance travelled. Error(kDiverged) where no finite cost was found.
/// UsageError for settings that cannot be used, and as check_smoothing(). BatchStopped as `stop`
/// says.
VelocityBatchResult smooth(const VelocityBatchInput& input, const BatchSettings& settings,
                           const StopRequest& stop = {});

}  // namespace chasles
