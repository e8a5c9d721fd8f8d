#pragma once

#include <nlohmann/json_fwd.hpp>

#include <chasles/data/recording.hpp>
#include <chasles/data/run.hpp>
#include <chasles/slam/inertial_slam.hpp>

namespace chasles::app {

class Interrupt;

/// A recording with an IMU after the filter has gone through it, from the true state at the first
/// frame that has one.
struct InertialDrive {
  Run run;
  ImuBuffer::Counts imu;
  ImuNoise imu_noise;
  double pixel_sigma = 0;    ///< [px]
  bool interrupted = false;  ///< by a signal: `run` ends early
};

/// Throws Error(kNotInitialised) where there is no truth to start from, InputError where cameras or
/// the IMU's noise are missing.
InertialDrive drive(const Recording& recording, const InertialSlamSettings& settings,
                    const Interrupt& interrupt, bool quiet);

/// summary.json, as that of the other recordings.
nlohmann::ordered_json summary_json(const InertialDrive& drive,
                                    const InertialSlamSettings& settings,
                                    const Recording& recording);

}  // namespace chasles::app
