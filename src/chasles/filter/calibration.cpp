#include <algorithm>
#include <utility>

#include <Eigen/Geometry>

#include <chasles/filter/calibration.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {

std::optional<Calibration> calibration_of(const Ekf& filter) {
  const State& x = filter.state();
  const int n = x.calibration_size();
  if (n == 0) return std::nullopt;
  return Calibration{
      .imu_T_camera = x.imu_T_camera,
      .time_offset = x.time_offset,
      .intrinsics = x.intrinsics,
      .imu = x.imu,
      .covariance = filter.covariance().block(x.calibration_row(), x.calibration_row(), n, n)};
}

Camera as_estimated(Camera camera, const State& x, int index) {
  if (x.camera_row(index)) {
    camera.cam_T_imu = x.imu_T_camera[static_cast<std::size_t>(index)].inverse();
  }
  if (x.intrinsics.empty()) return camera;
  return with_intrinsics(std::move(camera), x.intrinsics[static_cast<std::size_t>(index)]);
}

Intrinsics intrinsics_of(const Camera& camera) {
  return {.projection = {camera.fx, camera.fy, camera.cx, camera.cy},
          .readout = camera.shutter.readout,
          .coefficients = camera.coefficients,
          .has_readout = camera.shutter.is_rolling()};
}

Camera with_intrinsics(Camera camera, const Intrinsics& intrinsics) {
  camera.fx = intrinsics.projection[0];
  camera.fy = intrinsics.projection[1];
  camera.cx = intrinsics.projection[2];
  camera.cy = intrinsics.projection[3];
  camera.shutter.readout = std::max(intrinsics.readout, 0.0);
  camera.coefficients = intrinsics.coefficients;
  return camera;
}

Eigen::Vector3d moved_by_delay(const Camera& camera, const ReadoutMotion& motion, double delay,
                               const Eigen::Vector3d& p_cam, double w) {
  const SE3 imu_T_line = motion.after(delay);
  const Eigen::Vector3d turned = delay * motion.rate + delay * delay * motion.rate_change;
  const Eigen::Vector3d rate_line =
      so3::right_jacobian(turned) * (motion.rate + 2 * delay * motion.rate_change);
  const Eigen::Vector3d v_imu = motion.velocity + 2 * delay * motion.acceleration;
  // The camera's extrinsics are those of the IMU at the line, times imu_T_line^-1.
  const Eigen::Matrix3d cam_R_line = camera.cam_T_imu.R * imu_T_line.R;
  const SE3 line_T_cam = imu_T_line.inverse() * camera.cam_T_imu.inverse();
  const Eigen::Vector3d p_line = line_T_cam.R * p_cam + w * line_T_cam.p;
  return cam_R_line * (-rate_line.cross(p_line) - w * (imu_T_line.R.transpose() * v_imu));
}

IntrinsicsDerivative intrinsics_derivative(const Intrinsics& intrinsics, const Camera& camera,
                                           const ReadoutMotion& motion, double delay,
                                           const Eigen::Vector2d& pixel,
                                           const Eigen::Vector3d& p_cam, double w) {
  IntrinsicsDerivative result;
  result.blocks = intrinsics.blocks();
  const Eigen::Vector3d along = p_cam.normalized();
  if (const auto by = intrinsics.has_lens ? parameter_derivative(camera, along) : std::nullopt) {
    const Eigen::Index lens = by->cols() - 4;
    result.d.leftCols<4>() = by->leftCols<4>();
    result.d.middleCols(6, lens) = by->rightCols(lens);
  }
  if (!intrinsics.has_readout || !camera.shutter.is_rolling()) return result;
  result.p_cam_by_readout =
      line_part(camera, pixel) * moved_by_delay(camera, motion, delay, p_cam, w);
  const auto projection = project(camera, along);
  if (!projection) return result;
  result.d.col(Intrinsics::kReadoutRow) =
      projection->d_point * result.p_cam_by_readout / p_cam.norm();
  return result;
}

IntrinsicsDerivative intrinsics_derivative(const State& x, int index, const Camera& camera,
                                           const ReadoutMotion& motion,
                                           const Eigen::Vector2d& pixel,
                                           const Eigen::Vector3d& p_cam, double w) {
  return intrinsics_derivative(x.intrinsics[static_cast<std::size_t>(index)], camera, motion,
                               line_delay(camera, pixel), pixel, p_cam, w);
}

Camera as_estimated(Camera camera, const State& x, int index, const Eigen::Vector2d& pixel) {
  return at_line(as_estimated(std::move(camera), x, index), x.readout, pixel);
}

Camera as_estimated(Camera camera, const State& x, int index, const Clone& clone,
                    const Eigen::Vector2d& pixel) {
  return at_line(as_estimated(std::move(camera), x, index), clone.readout, pixel);
}

Vector9d motion_rate(const InertialState& state, const Eigen::Vector3d& gravity_world,
                     const ImuSample& sample) {
  const Eigen::Matrix3d& R = state.world_T_imu.R;
  Vector9d rate;
  rate << R * (sample.angular_rate_imu - state.gyroscope_bias), state.v_world,
      R * (sample.specific_force_imu - state.accelerometer_bias) + gravity_world;
  return rate;
}

void shift_with_time_offset(const State& x, const Vector9d& rate_before, const Vector9d& rate_after,
                            Prediction& prediction) {
  prediction.F.block<9, 1>(0, x.time_offset_row()) =
      rate_after - prediction.F.topLeftCorner<9, 9>() * rate_before;
}

NavState nav_state_by_clock(const Ekf& filter, const Vector9d& rate, NavScratch& scratch) {
  const State& x = filter.state();
  find_nav_derivative(x, scratch);
  Eigen::MatrixXd& J = scratch.derivative;
  const Eigen::Matrix<double, 15, 1> moved = J.leftCols<9>() * rate;
  J.col(x.time_offset_row()) -= moved;
  return nav_state(filter, scratch);
}

}  // namespace chasles
