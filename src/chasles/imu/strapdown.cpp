#include <cmath>

#include <chasles/imu/strapdown.hpp>

namespace chasles {
namespace {

// First rows of the blocks of StrapdownStep.
constexpr int kRotation = 0, kPosition = 3, kVelocity = 6, kAccelerometer = 9, kGyroscope = 12;

// s_n = sum over k of (-t^2)^k / (2k+n)!, in which the integrals of the exponential are
// Gamma_n(phi) = I/n! + s_{n+1} hat(phi) + s_{n+2} hat(phi)^2 (Gamma_1 = Jl), t = |phi|.
struct Coefficients {
  double s2, s3, s4, s5, s6;
};

// The recursion s_n = 1/n! - t^2 s_{n+2} is stable downwards for small angles and upwards for large
// ones; at the limit either way loses two digits at most.
Coefficients coefficients(double t) {
  const double t2 = t * t;
  Coefficients c{};
  if (t < 2) {
    double even = 1. / 720, odd = 1. / 120;
    c.s6 = even;
    c.s5 = odd;
    for (int k = 1; k <= 10; ++k) {
      odd *= -t2 / ((2 * k + 4) * (2 * k + 5));
      even *= -t2 / ((2 * k + 5) * (2 * k + 6));
      c.s5 += odd;
      c.s6 += even;
    }
    c.s4 = 1. / 24 - t2 * c.s6;
    c.s3 = 1. / 6 - t2 * c.s5;
    c.s2 = 1. / 2 - t2 * c.s4;
    return c;
  }
  c.s2 = (1 - std::cos(t)) / t2;
  c.s3 = (1 - std::sin(t) / t) / t2;
  c.s4 = (1. / 2 - c.s2) / t2;
  c.s5 = (1. / 6 - c.s3) / t2;
  c.s6 = (1. / 24 - c.s4) / t2;
  return c;
}

// d/d(phi) of a hat(phi) f + b hat(phi)^2 f, where a and b depend on |phi| and a_slope, b_slope are
// their derivatives divided by |phi|.
Eigen::Matrix3d derivative(const Eigen::Vector3d& phi, const Eigen::Vector3d& f, double a,
                           double a_slope, double b, double b_slope) {
  const Eigen::Matrix3d W = hat(phi);
  const Eigen::Vector3d once = W * f;
  const Eigen::Vector3d twice = W * once;
  return -a * hat(f) - b * (hat(once) + W * hat(f)) +
         (a_slope * once + b_slope * twice) * phi.transpose();
}

// d/d(phi) of Jl(phi) f and of Gamma2(phi) f. The slopes follow from s_n'(t) / t = n s_{n+2} -
// s_{n+1}, which unlike the textbook quotient has no cancellation at t = 0.
struct RotationDerivatives {
  Eigen::Matrix3d left_jacobian, gamma2;
};
RotationDerivatives rotation_derivatives(const Eigen::Vector3d& phi, const Eigen::Vector3d& f) {
  const auto [s2, s3, s4, s5, s6] = coefficients(phi.norm());
  return {.left_jacobian = derivative(phi, f, s2, 2 * s4 - s3, s3, 3 * s5 - s4),
          .gamma2 = derivative(phi, f, s3, 3 * s5 - s4, s4, 4 * s6 - s5)};
}

// Quantities shared by mean and transition. Without gravity, the sensors change v_world by tau
// R_left_jacobian f and p_world by tau^2 R_gamma2 f.
struct Motion {
  Eigen::Vector3d f;    // unbiased specific force, IMU axes
  Eigen::Vector3d phi;  // unbiased rotation vector of the interval, IMU axes
  Eigen::Matrix3d R_left_jacobian, R_gamma2;
};
Motion motion(const InertialState& state, const ImuInterval& interval) {
  const Eigen::Vector3d phi = (interval.angular_rate_imu - state.gyroscope_bias) * interval.tau;
  const Eigen::Matrix3d& R = state.world_T_imu.R;
  return {.f = interval.specific_force_imu - state.accelerometer_bias,
          .phi = phi,
          .R_left_jacobian = R * so3::left_jacobian(phi),
          .R_gamma2 = R * so3::gamma2(phi)};
}

InertialState moved(const InertialState& state, const Motion& m, double tau,
                    const Eigen::Vector3d& gravity_world) {
  InertialState next = state;
  next.world_T_imu.R = state.world_T_imu.R * so3::exp(m.phi);
  next.world_T_imu.p += tau * state.v_world + tau * tau * (m.R_gamma2 * m.f + gravity_world / 2);
  next.v_world += tau * (m.R_left_jacobian * m.f + gravity_world);
  return next;
}

Matrix15d transition(const Eigen::Matrix3d& R, const Motion& m, double tau) {
  const RotationDerivatives d = rotation_derivatives(m.phi, m.f);
  const double tau2 = tau * tau;
  Matrix15d F = Matrix15d::Identity();
  F.block<3, 3>(kRotation, kGyroscope) = -tau * m.R_left_jacobian;
  F.block<3, 3>(kPosition, kRotation) = -tau2 * hat(m.R_gamma2 * m.f);
  F.block<3, 3>(kPosition, kVelocity).diagonal().setConstant(tau);
  F.block<3, 3>(kPosition, kAccelerometer) = -tau2 * m.R_gamma2;
  F.block<3, 3>(kPosition, kGyroscope) = -tau2 * tau * R * d.gamma2;
  F.block<3, 3>(kVelocity, kRotation) = -tau * hat(m.R_left_jacobian * m.f);
  F.block<3, 3>(kVelocity, kAccelerometer) = -tau * m.R_left_jacobian;
  F.block<3, 3>(kVelocity, kGyroscope) = -tau2 * R * d.left_jacobian;
  return F;
}

// Standard deviation of the mean over an interval.
double white_sigma(double density, double extra_density, const ImuInterval& interval) {
  return std::sqrt((interval.noise_scale * density * density + extra_density * extra_density) /
                   interval.tau);
}

// The noise of a sample acts on pose and velocity like its bias (the sign does not matter).
Matrix15d noise_covariance(const Matrix15d& F, const ImuInterval& interval, const ImuNoise& noise) {
  Matrix15d Q = Matrix15d::Zero();
  const double tau = interval.tau;
  if (tau == 0) return Q;
  Eigen::Matrix<double, 9, 6> N;
  N.leftCols<3>() = white_sigma(noise.accelerometer_noise_density,
                                interval.accelerometer_extra_density, interval) *
                    F.block<9, 3>(0, kAccelerometer);
  N.rightCols<3>() =
      white_sigma(noise.gyroscope_noise_density, interval.gyroscope_extra_density, interval) *
      F.block<9, 3>(0, kGyroscope);
  // The product alone is not symmetric to the last bit.
  const Eigen::Matrix<double, 9, 9> S = N * N.transpose();
  Q.topLeftCorner<9, 9>() = (S + S.transpose()) / 2;
  const auto walk = [tau](double density) { return tau * density * density; };
  Q.diagonal().segment<3>(kAccelerometer).setConstant(walk(noise.accelerometer_random_walk));
  Q.diagonal().segment<3>(kGyroscope).setConstant(walk(noise.gyroscope_random_walk));
  return Q;
}

}  // namespace

StrapdownStep strapdown(const InertialState& state, const ImuInterval& interval,
                        const Eigen::Vector3d& gravity_world, const ImuNoise& noise) {
  const double tau = interval.tau;
  const Motion m = motion(state, interval);
  StrapdownStep step;
  step.state = moved(state, m, tau, gravity_world);
  step.F = transition(state.world_T_imu.R, m, tau);
  step.Q = noise_covariance(step.F, interval, noise);
  step.d_gravity.middleRows<3>(kPosition).diagonal().setConstant(tau * tau / 2);
  step.d_gravity.middleRows<3>(kVelocity).diagonal().setConstant(tau);
  return step;
}

InertialState integrate(const InertialState& state, const ImuInterval& interval,
                        const Eigen::Vector3d& gravity_world) {
  return moved(state, motion(state, interval), interval.tau, gravity_world);
}

}  // namespace chasles
