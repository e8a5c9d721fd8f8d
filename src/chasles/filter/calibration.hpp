#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>
#include <chasles/filter/inertial_model.hpp>
#include <chasles/imu/imu_sample.hpp>

/// Where the cameras are on the IMU, and how their clock stands against its own, as random
/// constants of the state (docs/inertial.md, section 6).
namespace chasles {

/// What is estimated of the arrangement of the sensors. The errors are, in this order, those of
/// every imu_T_camera, 6 each, R = Exp(phi) Rhat and p = phat + dp in the IMU's axes [rad, m], and
/// that of the time offset [s].
struct Calibration {
  std::vector<SE3> imu_T_camera;      ///< maps camera to IMU coordinates; empty: not estimated
  std::optional<double> time_offset;  ///< camera clock + time_offset = IMU clock [s]
  Eigen::MatrixXd covariance;
};

/// None where the filter estimates neither.
std::optional<Calibration> calibration_of(const Ekf& filter);

/// The camera where the state has it; as it is where its place is not estimated. `index`: in
/// State::imu_T_camera.
Camera as_estimated(Camera camera, const State& x, int index);

using Vector9d = Eigen::Matrix<double, 9, 1>;

/// How [rotation, position, v_world] move at an instant, in the coordinates of the standard error:
/// (R omega, v, R f + g), with the biases taken from the sample [rad/s, m/s, m/s^2].
Vector9d motion_rate(const InertialState& state, const Eigen::Vector3d& gravity_world,
                     const ImuSample& sample);

/// The column of the time offset in a prediction from one image to the next. The state is that of
/// the instant of the image, t + t_d; samples are integrated from t + t_d's estimate on. An error
/// of t_d shifts that window, and by it the end moves by its rate, the beginning by its own:
///
///   d next / d t_d = rate_after - F rate_before
///
/// which is what Li & Mourikis (2014, "Online temporal calibration for camera-IMU systems") have in
/// the Jacobian of every measurement, moved into the transition: so pixels, clones and composition
/// need not know of the offset. The derivative of the piecewise constant integral itself, but for
/// the change of the samples within one interval. The state must have a time_offset.
void shift_with_time_offset(const State& x, const Vector9d& rate_before, const Vector9d& rate_after,
                            Prediction& prediction);

/// nav_state of the instant t + t_d's estimate, which the IMU's clock tells, instead of that of the
/// image: `rate` is motion_rate there.
NavState nav_state_by_clock(const Ekf& filter, const Vector9d& rate, NavScratch& scratch);

}  // namespace chasles
