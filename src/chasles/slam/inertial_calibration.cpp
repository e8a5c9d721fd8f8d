#include <algorithm>

#include <chasles/slam/inertial_calibration.hpp>

namespace chasles {
namespace {

// The variance per axis of the samples from `begin` on.
double variance(const std::deque<ImuSample>& samples, Time begin,
                Eigen::Vector3d ImuSample::*value) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double squares = 0, count = 0;
  for (const ImuSample& sample : samples) {
    if (sample.time < begin || !(sample.*value).allFinite()) continue;
    mean += sample.*value;
    squares += (sample.*value).squaredNorm();
    ++count;
  }
  return count < 2 ? 0 : std::max(0.0, squares - mean.squaredNorm() / count) / (3 * count);
}

// The largest variance of a rotation about an axis of a camera.
double rotation_variance(const Calibration& calibration) {
  double result = 0;
  for (std::size_t i = 0; i < calibration.imu_T_camera.size(); ++i) {
    const auto row = 6 * static_cast<Eigen::Index>(i);
    result = std::max(result, calibration.covariance.diagonal().segment<3>(row).maxCoeff());
  }
  return result;
}

}  // namespace

std::optional<Calibration> stated_calibration(const InertialSlamSettings& s,
                                              std::span<const Camera> cameras) {
  if (!s.calibrate_extrinsics && !s.estimates_time_offset()) return std::nullopt;
  Calibration result;
  std::vector<double> sigmas;
  if (s.calibrate_extrinsics) {
    for (const Camera& camera : cameras) {
      result.imu_T_camera.push_back(camera.cam_T_imu.inverse());
      sigmas.insert(sigmas.end(), 3, s.initial_extrinsic_rotation_sigma);
      sigmas.insert(sigmas.end(), 3, s.initial_extrinsic_translation_sigma);
    }
  }
  if (s.estimates_time_offset()) {
    result.time_offset = s.initial_time_offset();
    sigmas.push_back(s.initial_time_offset_sigma);
  }
  const auto n = static_cast<Eigen::Index>(sigmas.size());
  result.covariance = Eigen::Map<const Eigen::VectorXd>(sigmas.data(), n).cwiseAbs2().asDiagonal();
  return result;
}

std::vector<Camera> calibrated(std::vector<Camera> cameras,
                               const std::optional<Calibration>& calibration) {
  if (!calibration || calibration->imu_T_camera.empty()) return cameras;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    cameras[i].cam_T_imu = calibration->imu_T_camera[i].inverse();
  }
  return cameras;
}

void widen_start(const Calibration& calibration, const std::deque<ImuSample>& samples,
                 InertialStart& start) {
  if (!start.covariance || samples.empty()) return;
  const Eigen::Index last = calibration.covariance.rows() - 1;
  const double time = calibration.time_offset ? calibration.covariance(last, last) : 0;  // s^2
  const double turn = time * variance(samples, start.time, &ImuSample::angular_rate_imu);
  const double push = time * variance(samples, start.time, &ImuSample::specific_force_imu);
  const double window = std::max(0.1, to_seconds(samples.back().time - start.time));
  auto diagonal = start.covariance->diagonal();
  diagonal.head<2>().array() += turn;
  diagonal.segment<3>(6).array() +=
      push + (turn + rotation_variance(calibration)) * start.v_nav.squaredNorm();
  diagonal.segment<3>(9).array() += 2 * push / (window * window);
  diagonal.segment<3>(12).array() += 2 * turn / (window * window);
}

}  // namespace chasles
