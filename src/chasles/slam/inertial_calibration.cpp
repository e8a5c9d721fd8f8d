#include <algorithm>
#include <string>
#include <utility>

#include <chasles/slam/inertial_calibration.hpp>
#include <chasles/slam/start_by_imu.hpp>

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
  if (!s.has_extrinsics() && !s.has_intrinsics() && !s.has_time_offset() && !s.has_imu()) {
    return std::nullopt;
  }
  Calibration result;
  std::vector<double> sigmas;
  if (s.has_extrinsics()) {
    for (const Camera& camera : cameras) {
      result.imu_T_camera.push_back(camera.cam_T_imu.inverse());
      sigmas.insert(sigmas.end(), 3, s.initial_extrinsic_rotation_sigma);
      sigmas.insert(sigmas.end(), 3, s.initial_extrinsic_translation_sigma);
    }
  }
  if (s.has_time_offset()) {
    result.time_offset = s.initial_time_offset();
    sigmas.push_back(s.initial_time_offset_sigma);
  }
  if (s.has_intrinsics()) {
    for (const Camera& camera : cameras) {
      Intrinsics one = intrinsics_of(camera);
      one.has_lens = is_in_state(s.calibrate_intrinsics);
      one.has_readout = is_in_state(s.calibrate_readout) && camera.shutter.is_rolling();
      result.intrinsics.push_back(one);
      const std::vector<double> of_lens = intrinsics_sigmas(s, camera);
      sigmas.insert(sigmas.end(), of_lens.begin(), of_lens.end());
    }
  }
  if (s.has_imu()) {
    result.imu = ImuCorrection{.has_scale = s.initial_imu_scale_sigma > 0,
                               .has_misalignment = s.initial_imu_misalignment_sigma > 0,
                               .has_g_sensitivity = s.initial_g_sensitivity_sigma > 0};
    const Eigen::VectorXd of_imu = imu_sigmas(s, *result.imu);
    sigmas.insert(sigmas.end(), of_imu.begin(), of_imu.end());
  }
  const auto n = static_cast<Eigen::Index>(sigmas.size());
  result.covariance = Eigen::Map<const Eigen::VectorXd>(sigmas.data(), n).cwiseAbs2().asDiagonal();
  return result;
}

std::vector<double> intrinsics_sigmas(const InertialSlamSettings& s, const Camera& camera) {
  constexpr double kTangential = 0.1;  // of the sigma of a radial coefficient
  const Intrinsics stated = intrinsics_of(camera);
  std::vector<double> sigmas(static_cast<std::size_t>(6 * stated.blocks()), 1);
  sigmas[0] = s.initial_focal_sigma * camera.fx;
  sigmas[1] = s.initial_focal_sigma * camera.fy;
  sigmas[2] = sigmas[3] = s.initial_principal_point_sigma;
  sigmas[Intrinsics::kReadoutRow] = s.initial_readout_sigma;
  const std::vector<std::string> names = coefficient_names(camera.distortion);
  for (std::size_t k = 0; k < stated.coefficients.size(); ++k) {
    const bool shears = names[k].front() == 'p' || names[k].front() == 's';
    sigmas[6 + k] = s.initial_distortion_sigma * (shears ? kTangential : 1);
  }
  return sigmas;
}

Eigen::VectorXd imu_sigmas(const InertialSlamSettings& s, const ImuCorrection& imu) {
  Eigen::VectorXd sigmas(imu.size());
  int row = 0;
  const auto add = [&](bool has, int count, double sigma) {
    if (!has) return;
    sigmas.segment(row, count).setConstant(sigma);
    row += count;
  };
  add(imu.has_scale, ImuCorrection::kScales, s.initial_imu_scale_sigma);
  add(imu.has_misalignment, ImuCorrection::kMisalignments, s.initial_imu_misalignment_sigma);
  add(imu.has_g_sensitivity, ImuCorrection::kGSensitivities, s.initial_g_sensitivity_sigma);
  return sigmas;
}

std::vector<int> considered_rows(const InertialSlamSettings& s, const State& x) {
  std::vector<int> rows;
  const auto add = [&](int first, int count) {
    for (int i = 0; i < count; ++i) rows.push_back(first + i);
  };
  if (s.calibrate_extrinsics == Calibrate::kConsidered) {
    add(x.calibration_row(), 6 * static_cast<int>(x.imu_T_camera.size()));
  }
  if (x.time_offset && s.calibrate_time_offset == Calibrate::kConsidered) {
    add(x.time_offset_row(), 1);
  }
  for (int i = 0; i < static_cast<int>(x.intrinsics.size()); ++i) {
    const int row = *x.intrinsics_row(i);
    const bool lens = s.calibrate_intrinsics == Calibrate::kConsidered;
    if (lens) add(row, Intrinsics::kReadoutRow);
    if (s.calibrate_readout == Calibrate::kConsidered) add(row + Intrinsics::kReadoutRow, 1);
    if (lens) add(row + 6, 6 * (x.intrinsics[static_cast<std::size_t>(i)].blocks() - 1));
  }
  if (x.imu && s.calibrate_imu == Calibrate::kConsidered) add(x.imu_row(), x.imu->size());
  return rows;
}

std::vector<Camera> calibrated(std::vector<Camera> cameras,
                               const std::optional<Calibration>& calibration) {
  if (!calibration) return cameras;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (!calibration->imu_T_camera.empty()) {
      cameras[i].cam_T_imu = calibration->imu_T_camera[i].inverse();
    }
    if (!calibration->intrinsics.empty()) {
      cameras[i] = with_intrinsics(std::move(cameras[i]), calibration->intrinsics[i]);
    }
  }
  return cameras;
}

void widen_start(const Calibration& calibration, const std::deque<ImuSample>& samples,
                 InertialStart& start) {
  if (!start.covariance || samples.empty()) return;
  if (calibration.imu) widen_start_by_imu(calibration, samples, start);
  const int row = calibration.time_offset_row();
  const double time = calibration.time_offset ? calibration.covariance(row, row) : 0;  // s^2
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
