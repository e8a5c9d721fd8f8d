#pragma once

#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <chasles/base/time.hpp>
#include <chasles/estimate/health.hpp>
#include <chasles/estimate/recent_tracks.hpp>
#include <chasles/filter/calibration.hpp>
#include <chasles/lie/se3.hpp>

namespace chasles {

/// Processor time of the stages of a filter for one frame [s]. No result depends on it.
struct StageSeconds {
  double propagation = 0;  ///< of the state since the previous frame
  double update = 0;       ///< association, gate and update
  double landmarks = 0;    ///< initialisation, change of form, retirement
};

/// Maximum numbers of additive states and of errors of the motion, so that an Estimate allocates no
/// memory.
inline constexpr int kMostAdditive = 13, kMostMotionErrors = 6 + kMostAdditive;
using AdditiveStates = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostAdditive, 1>;
using MotionCovariance =
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostMotionErrors, kMostMotionErrors>;

/// The pose in the frame of a prior map, once the run has found its place there.
struct PoseInMap {
  SE3 map_T_imu;
  /// Of its errors [rotation; position], standard error, axes of the map. It contains those of the
  /// map.
  Matrix6d covariance = Matrix6d::Zero();
  SE3 world_T_map;  ///< the frame of the map in that of the estimates
};

/// The result of an estimator for one frame: filter, window or batch, with an IMU or with body
/// velocities. Fields that do not apply to an estimator are absent.
struct Estimate {
  /// On the clock of the IMU or of the body velocities: the frame's time plus the time offset.
  Time time{};
  SE3 world_T_imu;
  std::optional<Eigen::Vector3d> v_world = {};  ///< [m/s]; with an IMU
  /// With an IMU: accelerometer bias 3 [m/s^2], gyroscope bias 3 [rad/s]. With body velocities: the
  /// states of BodyVelocityModel, named by VelocitySlam::additive_names.
  AdditiveStates additive = {};
  /// Covariance of the errors [theta; dp; v_world, if any; additive], standard error, world axes
  /// (docs/covariance.md): R = Exp(theta) R_hat, p = p_hat + dp [rad, m, m/s].
  MotionCovariance covariance = MotionCovariance::Zero(6, 6);

  double nis =
      0;  ///< of all observations of landmarks in the state together (and of the body velocity)
  int nis_dof = 0;  ///< its degrees of freedom; 0: no update, or no filter
  /// Sums over the pixels that updated the state in this frame and in the previous one, each
  /// innovation whitened by its covariance: of the products of both, and of their mean squares. The
  /// products of white innovations are 0 on average. Visual-inertial filter only.
  double innovation_products = 0, innovation_squares = 0;
  int observations = 0;  ///< of the frame
  int used = 0;          ///< that updated the state
  int rejected = 0;      ///< by the gate
  int added = 0;         ///< landmarks that the frame initialised
  int in_state = 0;      ///< landmarks in the state, or in the window, after the frame
  int landmarks = 0;     ///< of the whole map
  TrackUse tracks = {};  ///< null-space updates, where the settings allow only few landmarks
  Health health = Health::kOk;
  Degradation degradation = Degradation::kNone;  ///< the reason of kDegraded, of a filter or window
  bool zero_velocity = false;                    ///< a zero-velocity update was made
  std::optional<Calibration> calibration = {};   ///< where any of it is estimated
  /// Standard deviation of the relative scale [1]: filter with keep_scale (docs/filter.md)
  std::optional<double> scale_sigma = {};
  std::optional<StageSeconds> seconds = {};  ///< of a filter
  std::optional<PoseInMap> in_map = {};

  Matrix6d pose_covariance() const { return covariance.topLeftCorner<6, 6>(); }
  /// Standard deviations of the additive states, in their units.
  AdditiveStates additive_sigma() const {
    return covariance.diagonal().tail(additive.size()).cwiseSqrt();
  }
};

/// Moves `more` to the end of the other list.
inline void append(std::vector<Estimate> more, std::vector<Estimate>& estimates) {
  for (Estimate& e : more) estimates.push_back(std::move(e));
}

}  // namespace chasles
