#include <algorithm>
#include <vector>

#include <chasles/slam/start_by_imu.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;

// The samples of the window that a dynamic initialisation used. A standstill is before its start:
// there, the one that the start implies.
std::vector<ImuSample> samples_of(const std::deque<ImuSample>& samples,
                                  const InertialStart& start) {
  std::vector<ImuSample> used;
  std::ranges::copy_if(samples, std::back_inserter(used), [&](const ImuSample& sample) {
    return sample.time >= start.time && sample.specific_force_imu.allFinite() &&
           sample.angular_rate_imu.allFinite();
  });
  if (used.size() > 1) return used;
  const Vector3d up_imu = start.nav_T_imu.R.transpose() * Vector3d::UnitZ();
  return {{.time = start.time,
           .specific_force_imu = kStandardGravity * up_imu + start.accelerometer_bias,
           .angular_rate_imu = start.gyroscope_bias}};
}

}  // namespace

void widen_start_by_imu(const Calibration& calibration, const std::deque<ImuSample>& samples,
                        InertialStart& start) {
  if (!start.covariance) return;
  const ImuCorrection& imu = *calibration.imu;
  const std::vector<ImuSample> used = samples_of(samples, start);
  const auto derivative = [&](const ImuSample& sample) {
    return imu.derivative(sample.specific_force_imu, sample.angular_rate_imu);
  };
  const auto count = static_cast<double>(used.size());
  ImuCorrection::Derivative D = ImuCorrection::Derivative::Zero(6, imu.size());
  for (const ImuSample& sample : used) D += derivative(sample) / count;

  const Eigen::Matrix3d& R = start.nav_T_imu.R;
  const MatrixXd of_force = R * D.topRows<3>();
  start.by_imu = MatrixXd::Zero(15, imu.size());
  start.by_imu.row(0) = of_force.row(1) / kStandardGravity;
  start.by_imu.row(1) = -of_force.row(0) / kStandardGravity;
  start.by_imu.middleRows<3>(9) = R.row(2).transpose() * of_force.row(2);
  start.by_imu.bottomRows<3>() = D.bottomRows<3>();

  const int n = imu.size();
  const MatrixXd P = calibration.covariance.bottomRightCorner(n, n);
  Eigen::Matrix<double, 6, 1> variance = Eigen::Matrix<double, 6, 1>::Zero();
  for (const ImuSample& sample : used) {
    const ImuCorrection::Derivative varied = derivative(sample) - D;
    variance += (varied * P * varied.transpose()).diagonal() / count;
  }
  const double window = to_seconds(used.back().time - used.front().time);
  auto diagonal = start.covariance->diagonal();
  diagonal.head<2>().array() += window * window * variance.tail<3>().mean();
  diagonal.segment<3>(6).array() += window * window * variance.head<3>().mean();
  diagonal.tail<6>() += variance;
}

}  // namespace chasles
