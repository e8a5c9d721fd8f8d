#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/lie/trajectory.hpp>

// Two trajectories compared by their angular rates, which no world and no position enters.
namespace chasles {

/// The mean angular rate over an interval, in the axes of the body at its begin.
struct RateWindow {
  Time begin{}, end{};
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();  ///< [rad/s]
};

/// Intervals of about `length`, one after the other, between stamps of the trajectory. Those across
/// a gap of the stamps are left out; of more than `most` every n-th stays.
std::vector<RateWindow> rate_windows(const Trajectory& poses, Time length, std::size_t most = 1000);

/// The mean rate between two times, or none where the poses have a gap.
std::optional<Eigen::Vector3d> mean_rate(const Trajectory& poses, Time begin, Time end, Time gap);

/// reference rate = reference_R_truth * truth's rate + bias, the truth's times shifted by offset.
struct TurningFit {
  Eigen::Matrix3d reference_R_truth = Eigen::Matrix3d::Identity();
  Eigen::Vector3d bias = Eigen::Vector3d::Zero();  ///< [rad/s]; zero unless it was free
  double offset = 0;                               ///< truth's time + offset = reference's time [s]
  double offset_sigma = 0;                         ///< [s]
  double rotation_sigma = 0;                       ///< about the least certain axis [rad]
  double residual = 0;      ///< root mean square of the smaller 90 % of the residuals [rad/s]
  double signal = 0;        ///< the same of the reference's rates without the bias [rad/s]
  std::size_t windows = 0;  ///< compared

  /// The share of the motion that the fit does not explain, from 0 to about 1.
  double unexplained() const { return signal > 0 ? residual / signal : 1; }
};

struct TurningOptions {
  Time gap = kLongestTruthGap;  ///< between poses of the truth that are interpolated
  bool biased = false;          ///< whether the reference's rates have a constant bias
};

/// Least squares over rotation, offset and bias by Gauss-Newton, with weights that make outliers
/// small (Cauchy). The sigmas come from the scores of 20 blocks in time (sandwich estimator), so
/// that residuals may be correlated. An axis that the motion does not determine keeps its start and
/// gets a sigma of 1 rad. Nothing for fewer than 20 windows within the truth.
std::optional<TurningFit> fit_turning(const std::vector<RateWindow>& reference,
                                      const Trajectory& truth, double start_offset,
                                      const TurningOptions& options = {});

/// The residual (as in TurningFit) with that rotation and offset; a free bias is fitted.
double turning_residual(const std::vector<RateWindow>& reference, const Trajectory& truth,
                        double offset, const Eigen::Matrix3d& reference_R_truth,
                        const TurningOptions& options = {});

}  // namespace chasles
