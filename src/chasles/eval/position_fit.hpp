#pragma once

#include <optional>

#include <Eigen/Core>

#include <chasles/lie/trajectory.hpp>

// Two trajectories compared by their positions. The attitudes of the truth are not used.
namespace chasles {

struct PositionFitOptions {
  bool scale = false;           ///< a free scale factor
  bool offset = false;          ///< a free shift of the truth's clock
  bool point = false;           ///< a free point on the body, whose positions the truth has
  double start_offset = 0;      ///< truth's time + offset = estimate's time [s]
  Time gap = kLongestTruthGap;  ///< between poses of the truth that are interpolated
};

/// p_truth(t - offset) = truth_T_estimate.p + scale * truth_T_estimate.R (p_estimate(t) +
/// R_estimate(t) point).
struct PositionFit {
  SE3 truth_T_estimate;
  double scale = 1;
  double offset = 0, offset_sigma = 0;              ///< [s]
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< in the axes of the estimate's body [m]
  double point_sigma = 0;                           ///< along the least certain axis [m]
  double rms = 0;      ///< of the distances that are left [m, the truth's unit]
  double extent = 0;   ///< root mean square of the truth's distance from its mean
  double breadth = 0;  ///< the same along the second of its principal axes
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();  ///< the first of these
  double mirrored_rms = 0;  ///< that a reflection leaves, as rms; not less than without one
  std::size_t matched = 0;
};

/// Least squares over a rigid motion and what the options set free, by Gauss-Newton from the closed
/// form of align(). The sigmas come from the scores of 10 blocks in time (sandwich estimator).
/// Nothing for fewer than 10 pairs, or for positions that are all the same. Poses beyond 3000 are
/// thinned out.
std::optional<PositionFit> fit_positions(const Trajectory& estimate, const Trajectory& truth,
                                         const PositionFitOptions& options = {});

/// The root mean square distance after the best rigid motion at that offset, or none.
std::optional<double> aligned_rms(const Trajectory& estimate, const Trajectory& truth,
                                  double offset, Time gap = kLongestTruthGap);

}  // namespace chasles
