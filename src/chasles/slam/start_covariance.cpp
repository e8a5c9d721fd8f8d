#include <chasles/slam/start_covariance.hpp>

namespace chasles {

Matrix15d start_covariance(const InertialSlamSettings& s, const InertialStart& start) {
  if (start.covariance) return *start.covariance;
  Eigen::Matrix<double, 15, 1> sigma = Eigen::Matrix<double, 15, 1>::Zero();
  sigma.head<2>().setConstant(s.initial_tilt_sigma);
  sigma.segment<3>(6).setConstant(s.initial_velocity_sigma);
  sigma.segment<3>(9).setConstant(s.initial_accelerometer_bias_sigma);
  sigma.tail<3>().setConstant(s.initial_gyroscope_bias_sigma);
  return sigma.cwiseAbs2().asDiagonal();
}

}  // namespace chasles
