#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <chasles/data/recording.hpp>
#include <chasles/pipeline/truth.hpp>
#include <chasles/slam/inertial_slam.hpp>
#include <chasles/smooth/batch/batch_settings.hpp>

namespace chasles {

/// An estimator under test: a filter, or batch estimation that begins at that filter's run, or a
/// window that begins where the filter does.
struct FilterVariant {
  std::string name;
  InertialSlamSettings settings;
  std::optional<BatchSettings> batch = {};  ///< of batch estimation or a window
  int window = 0;                           ///< keyframes; 0: no window
};

/// What a filter was wrong by at a frame, and by how much it said it might be. NEES are those of
/// nav_T_imu in the coordinates of the filter's chart (pose_error_of); NaN where the covariance is
/// singular, as at the start, where position and heading are known. Errors and NEES are NaN where
/// the truth is not known.
struct TrialPoint {
  double seconds = 0;                                          ///< since the start
  double position_error = 0;                                   ///< [m]
  double attitude_error = 0;                                   ///< [rad]
  double nees_position = 0, nees_attitude = 0, nees_pose = 0;  ///< expected: 3, 3, 6
  double nees_state = 0;  ///< pose, velocity and biases, where all are known; expected: 15
  double nis = 0;
  int nis_dof = 0;
  double innovation_products = 0, innovation_squares = 0;  ///< as in Estimate
};

/// One filter over one recording.
struct Trial {
  std::string filter;
  std::uint64_t run = 0;
  bool diverged = false;  ///< not finite, or farther from the truth than kDivergedAt
  std::vector<TrialPoint> points = {};
  Trajectory estimate = {};  ///< nav_T_imu
  /// As in TrialAverages; NaN after divergence.
  double ate = std::nan(""), ate_posyaw = std::nan(""), attitude_posyaw = std::nan("");
  int landmarks = 0;  ///< of the whole map
  double seconds_cpu = 0;
  std::optional<Calibration> calibration = {};  ///< at the end, where it is estimated
};

inline constexpr double kDivergedAt = 20;  ///< [m]

/// Averages over a trial's frames; NaN entries do not count, and what has no entry is NaN.
struct TrialAverages {
  double position_error = 0, attitude_error = 0;  ///< means [m, rad]
  double position_rms = 0;                        ///< [m]
  double ate = 0;                                 ///< rms after alignment by SE(3) [m]
  double ate_posyaw = 0;                          ///< the same by position and yaw [m]
  double attitude_posyaw = 0;                     ///< rms with that alignment [rad]
  double nees_position = 0, nees_attitude = 0, nees_pose = 0, nees_state = 0;
  double nis_per_dof = 0;  ///< sum of NIS over sum of its degrees of freedom
  /// Correlation of a pixel's innovation with that of the frame before: 0 if they are white.
  double innovation_correlation = 0;
  double landmarks = 0;  ///< of the whole map
};
TrialAverages averages(const Trial& trial);

/// Calls visit(pointer to member) for each of them.
template <typename Visitor>
void for_each_average(Visitor&& visit) {
  using A = TrialAverages;
  for (double A::*member :
       {&A::position_error, &A::attitude_error, &A::position_rms, &A::ate, &A::ate_posyaw,
        &A::attitude_posyaw, &A::nees_position, &A::nees_attitude, &A::nees_pose, &A::nees_state,
        &A::nis_per_dof, &A::innovation_correlation, &A::landmarks}) {
    visit(member);
  }
}

/// A start for the filter: true_start() (pipeline/truth.hpp) with the errors that the settings say
/// drawn from their own distribution (tilt, velocity; biases are unknown and begin at 0). The same
/// seed and run give the same draw for every filter. Throws InputError where there is no truth.
InertialStart draw_start(const Recording& recording, const InertialSlamSettings& settings,
                         std::uint64_t seed, std::uint64_t run);

/// Adds an estimate to a trial, in the order of time, and ends a trial that has all of them; false
/// once it has diverged. Errors are in the coordinates of that chart.
bool add_to_trial(const std::string& chart, const Recording& recording, Time start,
                  const Estimate& estimate, Trial& trial);
void end_trial(const Recording& recording, Trial& trial);

/// Runs the filter over a recording, from the start on, as long as `take` returns true; throws
/// InputError where cameras, samples or frames are missing.
void run_filter(const FilterVariant& filter, const Recording& recording, const InertialStart& start,
                const std::function<bool(const Estimate&)>& take);

/// Runs the filter over a recording that has truth, cameras and an IMU, from the start on, and
/// batch estimation from there, or a window instead, where it is one; throws InputError where one
/// is missing. A batch or window that finds no minimum, or refuses the problem, has diverged.
Trial run_trial(const FilterVariant& filter, const Recording& recording,
                const InertialStart& start);

}  // namespace chasles
