#pragma once

#include <chasles/pipeline/run_settings.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/run_folder/run.hpp>

namespace chasles {

/// A run whose states are those at the times of the IMU's samples.
struct PredictedPath {
  Run run;
  std::size_t without = 0;  ///< samples without a state, between the first state and the last one
};

/// From each state on, the IMU alone predicts the next ones (StatePredictor): what a controller
/// would have had without delay, so the path jumps where a frame corrects it. None while the run is
/// lost, in gaps and long after a state. Covariances have no correlation of the pose with
/// velocity and biases, which states.csv does not have. The recording is that of as_in_run(); all
/// but the states of the run stays. Needs 1 kB a sample. Throws InputError for a run without
/// velocities and biases, or with parameters of the IMU in its state, and for a recording without
/// the IMU's samples or noise.
PredictedPath predicted_path(const Run& run, const Recording& recording,
                             const InertialRunSettings& settings);

}  // namespace chasles
