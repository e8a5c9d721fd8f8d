#include <utility>

#include <chasles/filter/calibration.hpp>

namespace chasles {

std::optional<Calibration> calibration_of(const Ekf& filter) {
  const State& x = filter.state();
  const int n = x.calibration_size();
  if (n == 0) return std::nullopt;
  return Calibration{
      .imu_T_camera = x.imu_T_camera,
      .time_offset = x.time_offset,
      .covariance = filter.covariance().block(x.calibration_row(), x.calibration_row(), n, n)};
}

Camera as_estimated(Camera camera, const State& x, int index) {
  if (x.camera_row(index)) {
    camera.cam_T_imu = x.imu_T_camera[static_cast<std::size_t>(index)].inverse();
  }
  return camera;
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
