#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>
#include <chasles/filter/inertial_model.hpp>
#include <chasles/imu/imu_sample.hpp>

/// Camera extrinsics, intrinsics, time offset and the IMU's parameters as random constants of the
/// state (docs/inertial.md, section 6).
namespace chasles {

/// Estimated calibration of the sensors. The errors are, in this order: those of every
/// imu_T_camera, 6 each, R = Exp(phi) Rhat and p = phat + dp in IMU axes [rad, m]; that of the time
/// offset [s]; those of the intrinsics, as in Intrinsics; and those of the IMU's parameters.
struct Calibration {
  std::vector<SE3> imu_T_camera;      ///< maps camera to IMU coordinates; empty: not estimated
  std::optional<double> time_offset;  ///< camera clock + time_offset = IMU clock [s]
  std::vector<Intrinsics> intrinsics = {};  ///< of every camera; empty: not estimated
  std::optional<ImuCorrection> imu = {};    ///< none: known
  Eigen::MatrixXd covariance = {};

  int time_offset_row() const { return 6 * static_cast<int>(imu_T_camera.size()); }
  /// The first row of the intrinsics.
  int intrinsics_row() const { return time_offset_row() + (time_offset ? 1 : 0); }
  /// The first row of the IMU's parameters, with `imu`.
  int imu_row() const { return static_cast<int>(covariance.rows()) - imu->size(); }
};

/// The intrinsics that a camera states.
Intrinsics intrinsics_of(const Camera& camera);
/// The camera with these intrinsics.
Camera with_intrinsics(Camera camera, const Intrinsics& intrinsics);

/// The derivative of a pixel by the intrinsics of its camera, in blocks of six rows.
struct IntrinsicsDerivative {
  static constexpr int kMostBlocks = 3;
  Eigen::Matrix<double, 2, 6 * kMostBlocks> d =
      Eigen::Matrix<double, 2, 6 * kMostBlocks>::Zero();  ///< [px] by the errors
  /// How the point moves in the camera's frame as the readout grows, times w [m/s].
  Eigen::Vector3d p_cam_by_readout = Eigen::Vector3d::Zero();
  int blocks = 0;

  auto block(int i) const { return d.middleCols<6>(6 * i); }
};

/// How a point moves in a camera's frame as the pixel is seen later, times w [m/s]. `camera`: at
/// that line, `delay` [s] after the time of the image. `p_cam` / w is the point [m]. The errors of
/// the `motion` in which the line was read (camera/rolling_shutter.hpp) are neglected.
Eigen::Vector3d moved_by_delay(const Camera& camera, const ReadoutMotion& motion, double delay,
                               const Eigen::Vector3d& p_cam, double w);

/// `camera`: with these `intrinsics`. The others as in moved_by_delay.
IntrinsicsDerivative intrinsics_derivative(const Intrinsics& intrinsics, const Camera& camera,
                                           const ReadoutMotion& motion, double delay,
                                           const Eigen::Vector2d& pixel,
                                           const Eigen::Vector3d& p_cam, double w);
/// The same for a `camera` that is that of `index` as estimated, at the line of the pixel. The
/// state must have intrinsics.
IntrinsicsDerivative intrinsics_derivative(const State& x, int index, const Camera& camera,
                                           const ReadoutMotion& motion,
                                           const Eigen::Vector2d& pixel,
                                           const Eigen::Vector3d& p_cam, double w);

/// The filter's calibration estimate; none if nothing of it is in the state.
std::optional<Calibration> calibration_of(const Ekf& filter);

/// The camera with the extrinsics of the state; unchanged if they are not estimated. `index`: into
/// State::imu_T_camera.
Camera as_estimated(Camera camera, const State& x, int index);

/// The same at the line of a pixel (camera/rolling_shutter.hpp), from the present pose or a clone.
Camera as_estimated(Camera camera, const State& x, int index, const Eigen::Vector2d& pixel);
Camera as_estimated(Camera camera, const State& x, int index, const Clone& clone,
                    const Eigen::Vector2d& pixel);

using Vector9d = Eigen::Matrix<double, 9, 1>;

/// The rate of [rotation, position, v_world] at an instant, in the coordinates of the standard
/// error: (R omega, v, R f + g), with the biases subtracted from the sample [rad/s, m/s, m/s^2].
Vector9d motion_rate(const InertialState& state, const Eigen::Vector3d& gravity_world,
                     const ImuSample& sample);

/// Writes the column of the time offset in a prediction from one image to the next. The state is
/// that of the instant of the image, t + t_d. Samples are integrated from the estimate of t + t_d
/// on. An error of t_d shifts this interval: its end moves by rate_after, its start by rate_before:
///
///   d next / d t_d = rate_after - F rate_before
///
/// Li & Mourikis (2014, "Online temporal calibration for camera-IMU systems") have this term in the
/// Jacobian of every measurement. Here it is in the transition, so that pixels, clones and
/// composition do not depend on the offset. It is the derivative of the piecewise constant
/// integral, except for the change of the samples within one interval. The state must have a
/// time_offset.
void shift_with_time_offset(const State& x, const Vector9d& rate_before, const Vector9d& rate_after,
                            Prediction& prediction);

/// nav_state at the estimate of t + t_d, in the IMU's clock, instead of at the instant of the
/// image. `rate` is motion_rate there.
NavState nav_state_by_clock(const Ekf& filter, const Vector9d& rate, NavScratch& scratch);

}  // namespace chasles
