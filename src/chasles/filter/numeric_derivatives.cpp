#include <cassert>
#include <optional>

#include <chasles/filter/numeric_derivatives.hpp>

namespace chasles {
namespace {

using Derivatives = Eigen::Matrix<double, 2, 9>;

// Balances round-off in pixels of some thousands against the third derivative [rad, m].
constexpr double kStep = 1e-5;

// Pose and landmark alone: rows 0 to 5 and 6 to 8.
State alone(const State& x, int landmark) {
  State part;
  part.world_T_imu = x.world_T_imu;
  part.landmarks = {x.landmarks[static_cast<std::size_t>(landmark)]};
  part.landmarks.front().row = 6;
  return part;
}

std::optional<Eigen::Vector2d> pixel_of(const Camera& camera, const State& x) {
  const auto seen =
      project(camera, camera.cam_T_imu * (x.world_T_imu.inverse() * x.landmarks.front().p_world));
  if (!seen) return std::nullopt;
  return seen->pixel;
}

}  // namespace

void differentiate_numerically(const ErrorChart& chart, const Camera& camera, const State& x,
                               Measurement& measurement) {
  const State at = alone(x, measurement.landmark);
  assert(!at.landmarks.front().anchor && x.imu_T_camera.empty());
  Derivatives in_chart;
  for (int i = 0; i < in_chart.cols(); ++i) {
    State forth = at, back = at;
    const Eigen::VectorXd error = kStep * Eigen::VectorXd::Unit(in_chart.cols(), i);
    chart.retract(forth, error);
    chart.retract(back, -error);
    const auto more = pixel_of(camera, forth), less = pixel_of(camera, back);
    if (!more || !less) return;
    in_chart.col(i) = (*more - *less) / (2 * kStep);
  }
  Eigen::MatrixXd T = Eigen::MatrixXd::Identity(in_chart.cols(), in_chart.cols());
  push(chart, at, T);
  const Derivatives derivatives = in_chart * T;
  measurement.d_core = derivatives.leftCols<6>();
  measurement.d_landmark = derivatives.rightCols<3>();
}

}  // namespace chasles
