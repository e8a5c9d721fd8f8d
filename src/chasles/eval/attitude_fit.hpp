#pragma once

#include <cstddef>
#include <optional>

#include <Eigen/Core>

#include <chasles/lie/trajectory.hpp>

// Two trajectories compared by their attitudes. No position is used.
namespace chasles {

struct AttitudeFitOptions {
  double offset = 0;            ///< truth's time + offset = estimate's time [s]
  Time gap = kLongestTruthGap;  ///< between poses of the truth that are interpolated
  /// The rotation between the worlds, where it is known. Otherwise it is fitted.
  std::optional<Eigen::Matrix3d> truth_R_estimate = {};
  bool body = false;  ///< a free rotation of the axes on the body
};

/// R_truth(t - offset) = truth_R_estimate R_estimate(t) body.
struct AttitudeFit {
  Eigen::Matrix3d truth_R_estimate = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d body = Eigen::Matrix3d::Identity();  ///< imu_R_truth
  double rms = 0;                                      ///< of the angles that are left [rad]
  double excursion = 0;     ///< root mean square angle of the estimate from its mean [rad]
  std::size_t matched = 0;  ///< attitudes compared
};

/// The chordal means, alternately where both rotations are free. Nothing for fewer than 10 pairs.
std::optional<AttitudeFit> fit_attitudes(const Trajectory& estimate, const Trajectory& truth,
                                         const AttitudeFitOptions& options = {});

/// What may be left of attitudes that follow the estimate's: half of the excursion, and 5 degrees.
double unlike_attitudes_limit(const AttitudeFit& fit);

}  // namespace chasles
