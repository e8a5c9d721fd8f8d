#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include <chasles/eval/nees.hpp>
#include <chasles/pipeline/run_settings.hpp>
#include <chasles/pipeline/truth.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/slam/inertial_slam.hpp>

namespace chasles {

/// An estimator under test: a filter, or batch estimation initialised by that filter's run, or a
/// window with the filter's start.
struct FilterVariant {
  std::string name;
  InertialSlamSettings settings;
  EstimatorChoice estimator = {};
  BatchSettings batch = {};  ///< of batch estimation or a window
};

/// The error of a filter at a frame and its NEES. NEES are those of nav_T_imu in the coordinates of
/// the filter's chart (pose_error_of). They are NaN where the covariance is singular, as at the
/// start, where position and heading are given. Errors and NEES are NaN where the truth is unknown.
struct TrialPoint {
  double seconds = 0;                                          ///< since the start
  double position_error = 0;                                   ///< [m]
  double attitude_error = 0;                                   ///< [rad]
  double nees_position = 0, nees_attitude = 0, nees_pose = 0;  ///< expected: 3, 3, 6
  double nees_state = 0;  ///< pose, velocity and biases, if all have a truth; expected: 15
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
  Trajectory estimate = {};           ///< nav_T_imu
  std::vector<MapLandmark> map = {};  ///< at the end, in nav; of a filter only with KeepMap::kYes
  /// Errors and NEES of the smoothed path, likewise, where the filter has it (exact_map).
  std::vector<TrialPoint> smoothed = {};
  /// As in TrialAverages; NaN after divergence.
  double ate = std::nan(""), ate_posyaw = std::nan(""), attitude_posyaw = std::nan("");
  int landmarks = 0;  ///< of the whole map
  double seconds_cpu = 0;
  std::optional<Calibration> calibration = {};  ///< at the end, where it is estimated
};

inline constexpr double kDivergedAt = 20;  ///< [m]

/// Averages over a trial's frames. NaN entries do not count; without any entry the average is NaN.
struct TrialAverages {
  double position_error = 0, attitude_error = 0;  ///< means [m, rad]
  double position_rms = 0;                        ///< [m]
  double ate = 0;                                 ///< rms after alignment by SE(3) [m]
  double ate_posyaw = 0;                          ///< the same by position and yaw [m]
  double attitude_posyaw = 0;                     ///< rms with that alignment [rad]
  double nees_position = 0, nees_attitude = 0, nees_pose = 0, nees_state = 0;
  double nis_per_dof = 0;  ///< sum of NIS over sum of its degrees of freedom
  /// Correlation of a pixel's innovation with that in the previous frame: 0 for white innovations.
  double innovation_correlation = 0;
  double landmarks = 0;  ///< of the whole map
};
TrialAverages averages(const Trial& trial);

/// Calls visit(pointer to member) for each member.
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

/// A start for the filter: true_start() (pipeline/truth.hpp) with initial errors of tilt and
/// velocity, drawn from the distribution that the settings define; biases are unknown and start at
/// 0. The same seed and run give the same draw for every filter. Throws InputError without a truth.
InertialStart draw_start(const Recording& recording, const InertialSlamSettings& settings,
                         std::uint64_t seed, std::uint64_t run);

/// add_to_trial() adds an estimate to a trial, in order of time, and returns false once the trial
/// has diverged; end_trial() completes the trial. Errors are in the coordinates of that chart.
bool add_to_trial(const std::string& chart, const Recording& recording, Time start,
                  const Estimate& estimate, Trial& trial);
void end_trial(const Recording& recording, Trial& trial);

/// Runs the filter over a recording from the start on, as long as `take` returns true; `done` then
/// receives the filter, where given. Throws InputError if cameras, samples or frames are missing.
void run_filter(const FilterVariant& filter, const Recording& recording, const InertialStart& start,
                const std::function<bool(const Estimate&)>& take,
                const std::function<void(const InertialSlam&)>& done = {});

/// The error of a pose at `seconds` and its NEES in those coordinates; the rest is NaN or zero.
TrialPoint pose_point(double seconds, const SE3& truth, const SE3& pose, const Matrix6d& covariance,
                      PoseError coordinates);

/// Whether a trial has map and smoothed path: they cost a pass over the whole run.
enum class KeepMap { kNo, kYes };

/// Runs the filter over a recording that has truth, cameras and an IMU, from the start on; then
/// batch estimation initialised by it, or a window instead, if the variant has one. Throws
/// InputError if one of the inputs is missing. A batch or window that finds no minimum, or cannot
/// solve the problem, counts as diverged.
Trial run_trial(const FilterVariant& filter, const Recording& recording, const InertialStart& start,
                KeepMap keep_map = KeepMap::kNo);

}  // namespace chasles
