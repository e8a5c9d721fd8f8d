#include <algorithm>
#include <cmath>

#include <chasles/initialise/static_start.hpp>
#include <chasles/lie/small_matrices.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

// Variance of the mean of white noise over the window; at least that of the stated noise.
double variance_of_mean(double density, double sigma, double expected, double seconds) {
  const double excess = expected > 0 ? std::max(1.0, sigma / expected) : 1;
  return std::pow(density * excess, 2) / seconds;
}

// [tilt x, tilt y, accelerometer bias] in nav, from the force in nav axes: R f = -g + theta x g + b
// + n, where theta is the error of the tilt.
struct TiltAndBias {
  Eigen::Vector3d bias_nav;
  Eigen::Matrix<double, 5, 5> covariance;
};
TiltAndBias tilt_and_bias(double force, double gravity, double noise_variance, double bias_sigma) {
  Eigen::Matrix<double, 3, 5> H = Eigen::Matrix<double, 3, 5>::Zero();
  H(0, 1) = -gravity;
  H(1, 0) = gravity;
  H.rightCols<3>().setIdentity();
  Eigen::Matrix<double, 5, 5> information = H.transpose() * H / noise_variance;
  information.diagonal().tail<3>().array() += 1 / (bias_sigma * bias_sigma);
  const Eigen::Matrix<double, 5, 5> P = inverse_symmetric(information);
  const Eigen::Matrix<double, 5, 1> x =
      P * H.transpose() * Eigen::Vector3d(0, 0, force - gravity) / noise_variance;
  return {.bias_nav = x.tail<3>(), .covariance = (P + P.transpose()) / 2};
}

}  // namespace

StandstillMeans standstill_means(std::span<const ImuSample> samples, const ImuNoise& noise) {
  StandstillMeans means;
  const auto n = static_cast<double>(samples.size());
  means.seconds = to_seconds(samples.back().time - samples.front().time) * n / (n - 1);
  for (const ImuSample& s : samples) {
    means.specific_force_imu += s.specific_force_imu / n;
    means.angular_rate_imu += s.angular_rate_imu / n;
  }
  double force = 0, rate = 0;
  for (const ImuSample& s : samples) {
    force += (s.specific_force_imu - means.specific_force_imu).squaredNorm();
    rate += (s.angular_rate_imu - means.angular_rate_imu).squaredNorm();
  }
  means.accelerometer_sigma = std::sqrt(force / (3 * (n - 1)));
  means.gyroscope_sigma = std::sqrt(rate / (3 * (n - 1)));
  const double root_rate = std::sqrt(n / means.seconds);
  means.accelerometer_expected = noise.accelerometer_noise_density * root_rate;
  means.gyroscope_expected = noise.gyroscope_noise_density * root_rate;
  return means;
}

InertialStart static_start(Time end, const StandstillMeans& means, const ImuNoise& noise,
                           const InitialiserSettings& settings) {
  const double force_variance =
      variance_of_mean(noise.accelerometer_noise_density, means.accelerometer_sigma,
                       means.accelerometer_expected, means.seconds);
  const double rate_variance =
      variance_of_mean(noise.gyroscope_noise_density, means.gyroscope_sigma,
                       means.gyroscope_expected, means.seconds);
  const Eigen::Matrix3d nav_R_imu =
      so3::between(means.specific_force_imu, Eigen::Vector3d::UnitZ());
  const TiltAndBias fit = tilt_and_bias(means.specific_force_imu.norm(), settings.gravity,
                                        force_variance, settings.accelerometer_bias_sigma);
  const double prior = std::pow(settings.gyroscope_bias_sigma, 2);
  const double gain = prior / (prior + rate_variance);

  InertialStart start{.time = end, .nav_T_imu = {.R = nav_R_imu}};
  start.accelerometer_bias = nav_R_imu.transpose() * fit.bias_nav;
  start.gyroscope_bias = gain * means.angular_rate_imu;
  // From [tilt x, tilt y, bias in nav] to the rows of the start, whose biases are in IMU axes.
  Eigen::Matrix<double, 15, 5> J = Eigen::Matrix<double, 15, 5>::Zero();
  J.topLeftCorner<2, 2>().setIdentity();
  J.block<3, 3>(9, 2) = nav_R_imu.transpose();
  Matrix15d P = congruence(J, fit.covariance);
  P = (P + P.transpose()).eval() / 2;
  P.diagonal().segment<3>(6).setConstant(std::pow(settings.static_velocity_sigma, 2));
  P.diagonal().tail<3>().setConstant(gain * rate_variance);
  start.covariance = P;
  return start;
}

}  // namespace chasles
