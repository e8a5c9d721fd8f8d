#include <string>

#include <Eigen/LU>

#include <chasles/base/error.hpp>
#include <chasles/filter/first_order_transition.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// First rows of the errors: those of StrapdownStep, then that of gravity_world, which is constant.
constexpr int kTheta = 0, kPosition = 3, kVelocity = 6, kForceBias = 9, kRateBias = 12,
              kGravity = 15;
using Matrix18d = Eigen::Matrix<double, 18, 18>;
/// Columns: noise of the accelerometer and of the gyroscope, random walk of each bias.
using NoiseColumns = Eigen::Matrix<double, 18, 12>;

/// The linear differential equation of the error, e' = F e + G n.
struct ErrorEquation {
  Matrix18d F = Matrix18d::Zero();
  NoiseColumns G = NoiseColumns::Zero();

  auto by(int row, int column) { return F.block<3, 3>(row, column); }
  auto noise(int row, int column) { return G.block<3, 3>(row, column); }
};

/// Where it is linearised; force and rate are without bias, in IMU axes.
struct Linearised {
  Matrix3d world_R_imu;
  Vector3d p_world, v_world, force_imu, rate_imu, gravity_world;
};

ErrorEquation biases_only() {
  ErrorEquation e;
  e.noise(kForceBias, 6).setIdentity();  // (25)
  e.noise(kRateBias, 9).setIdentity();   // (27)
  return e;
}

// (23), (24) with the noise's sign of (11), (26). (48), (49) are the same.
ErrorEquation of_standard(const Linearised& x) {
  ErrorEquation e = biases_only();
  const Matrix3d& R = x.world_R_imu;
  e.by(kPosition, kVelocity).setIdentity();
  e.by(kVelocity, kTheta) = -hat(R * x.force_imu);
  e.by(kVelocity, kForceBias) = -R;
  e.by(kVelocity, kGravity).setIdentity();
  e.by(kTheta, kRateBias) = -R;
  e.noise(kVelocity, 0) = -R;
  e.noise(kTheta, 3) = -R;
  return e;
}

// (39), (40) corrected, (41).
ErrorEquation of_left_se3(const Linearised& x) {
  ErrorEquation e = biases_only();
  const Matrix3d imu_R_world = x.world_R_imu.transpose();
  const Matrix3d turn = -hat(x.rate_imu), by_rate = -hat(imu_R_world * x.v_world);
  e.by(kPosition, kTheta) = by_rate;
  e.by(kPosition, kPosition) = turn;
  e.by(kPosition, kVelocity).setIdentity();
  e.by(kVelocity, kVelocity) = turn;
  e.by(kVelocity, kTheta) = hat(imu_R_world * x.gravity_world);
  e.by(kVelocity, kForceBias) = -Matrix3d::Identity();
  e.by(kVelocity, kRateBias) = by_rate;
  e.by(kVelocity, kGravity) = imu_R_world;
  e.by(kTheta, kTheta) = turn;
  e.by(kTheta, kRateBias) = -Matrix3d::Identity();
  e.noise(kVelocity, 0) = -Matrix3d::Identity();
  e.noise(kVelocity, 3) = by_rate;
  e.noise(kTheta, 3) = -Matrix3d::Identity();
  return e;
}

// (47) repaired, (48), (49).
ErrorEquation of_right_se3(const Linearised& x) {
  ErrorEquation e = of_standard(x);
  e.by(kPosition, kTheta) = hat(x.v_world);
  e.by(kPosition, kRateBias) = -hat(x.p_world) * x.world_R_imu;
  e.noise(kPosition, 3) = -hat(x.p_world) * x.world_R_imu;
  return e;
}

ErrorEquation error_equation(const ErrorChart& chart, const Linearised& x) {
  if (chart.name == kStandardChart.name) return of_standard(x);
  if (chart.name == kLeftSe3Chart.name) return of_left_se3(x);
  if (chart.name == kRightSe3Chart.name) return of_right_se3(x);
  throw UsageError("first-order transition: found the chart '" + std::string(chart.name) +
                   "', expected standard, left-se3 or right-se3");
}

// T of the chart for pose and velocity; the other errors are the same in all charts.
Matrix18d chart_block(const ErrorChart& chart, const InertialState& state) {
  State x;
  x.world_T_imu = state.world_T_imu;
  x.v_world = state.v_world;
  Matrix18d T = Matrix18d::Identity();
  T.topLeftCorner<9, 9>() = chart.motion_block(x);
  return T;
}

Eigen::Matrix<double, 12, 1> spectral_density(const ImuInterval& interval, const ImuNoise& noise) {
  const auto square = [](double density) { return density * density; };
  const auto white = [&](double density, double extra) {
    return interval.noise_scale * square(density) + square(extra);
  };
  const Vector3d one = Vector3d::Ones();
  Eigen::Matrix<double, 12, 1> q;
  q << white(noise.accelerometer_noise_density, interval.accelerometer_extra_density) * one,
      white(noise.gyroscope_noise_density, interval.gyroscope_extra_density) * one,
      square(noise.accelerometer_random_walk) * one, square(noise.gyroscope_random_walk) * one;
  return q;
}

}  // namespace

void linearise_to_first_order(const ErrorChart& chart, const InertialState& state,
                              const ImuInterval& interval, const Vector3d& gravity_world,
                              const ImuNoise& noise, StrapdownStep& step) {
  const ErrorEquation e =
      error_equation(chart, {.world_R_imu = state.world_T_imu.R,
                             .p_world = state.world_T_imu.p,
                             .v_world = state.v_world,
                             .force_imu = interval.specific_force_imu - state.accelerometer_bias,
                             .rate_imu = interval.angular_rate_imu - state.gyroscope_bias,
                             .gravity_world = gravity_world});
  const Matrix18d phi = Matrix18d::Identity() + interval.tau * e.F;
  const Matrix18d to_reference = chart_block(chart, step.state).inverse();
  const Matrix18d F = to_reference * phi * chart_block(chart, state);
  const NoiseColumns noise_columns = to_reference * phi * e.G;
  const Matrix18d Q = noise_columns *
                      (interval.tau * spectral_density(interval, noise)).asDiagonal() *
                      noise_columns.transpose();
  step.F = F.topLeftCorner<15, 15>();
  step.Q = ((Q + Q.transpose()) / 2).topLeftCorner<15, 15>();
  step.d_gravity = F.block<15, 3>(0, kGravity);
}

}  // namespace chasles
