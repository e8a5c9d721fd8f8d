#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/calibration.hpp>
#include <chasles/calibration/imu_range.hpp>
#include <chasles/recording/apply_calibration.hpp>

namespace chasles {
namespace {

double largest_change(const Eigen::Matrix3d& M) {
  return (M - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff();
}

}  // namespace

ImuRange range_of(const Recording& recording) {
  ImuRange range = recording.imu_range;
  if (std::isfinite(range.accelerometer) && std::isfinite(range.gyroscope)) return range;
  const ImuRange seen = shown_range(recording.imu);
  if (!std::isfinite(range.accelerometer)) range.accelerometer = seen.accelerometer;
  if (!std::isfinite(range.gyroscope)) range.gyroscope = seen.gyroscope;
  return range;
}

void take_kalibr(const KalibrCalibration& calibration, Recording& recording) {
  recording.cameras = calibration.cameras;
  recording.imu_noise = calibration.imu_noise;
  recording.imu_range = calibration.imu_range;
  recording.remarks.insert(recording.remarks.end(), calibration.remarks.begin(),
                           calibration.remarks.end());
}

KalibrCalibration take_own_calibration(const std::filesystem::path& file, std::size_t cameras,
                                       Recording& recording) {
  FolderCalibration calibration = read_calibration(file);
  if (calibration.cameras.empty() || !calibration.imu_convention) {
    throw InputError(fmt::format(
        "{}: has no {}, expected both beside images", file.string(),
        calibration.cameras.empty() ? "cameras (a list)" : "imu_convention (and so no IMU)"));
  }
  cameras = std::min(cameras, calibration.cameras.size());
  calibration.cameras.resize(cameras);
  calibration.time_offsets.resize(cameras);
  recording.name = calibration.name;
  recording.cameras = calibration.cameras;
  recording.imu_convention = *calibration.imu_convention;
  recording.imu_noise = calibration.imu_noise;
  recording.imu_range = calibration.imu_range;
  recording.single_pixel_sigma = calibration.single_pixel_sigma;
  recording.truth_level = calibration.truth_level;
  recording.remarks = calibration.remarks;
  remark_on_time_offsets(calibration.time_offsets, recording.remarks);
  return {.time_offsets = calibration.time_offsets};
}

void take_noise_of_samples(const KalibrCalibration& calibration, Recording& recording) {
  const std::vector<ImuSample>& imu = recording.imu;
  if (!calibration.noise_of_samples || !recording.imu_noise || imu.size() < 2) return;
  const double interval =
      to_seconds(imu.back().time - imu.front().time) / static_cast<double>(imu.size() - 1);
  recording.imu_noise = scaled(*recording.imu_noise, std::sqrt(interval));
  recording.remarks.push_back(fmt::format(
      "the noise of the IMU is stated for a sample (VINS): its densities are that, over the root "
      "of the rate of {:.4g} Hz",
      1 / interval));
}

void correct_samples(const ImuIntrinsics& intrinsics, Recording& recording) {
  const ImuRange measured = range_of(recording);
  double force_on_rate = 0;
  for (ImuSample& s : recording.imu) {
    s = corrected(intrinsics, measured, s);
    const Eigen::Vector3d of_force = intrinsics.rate_of_force * s.specific_force_imu;
    force_on_rate = std::max(force_on_rate, of_force.cwiseAbs().maxCoeff());
  }
  recording.imu_range = corrected_range(intrinsics, measured, force_on_rate);
  recording.remarks.push_back(
      fmt::format("the samples are corrected by the IMU's intrinsics: accelerometer by up to "
                  "{:.3g} %, gyroscope "
                  "by up to {:.3g} % and {:.3g} rad/s for the force",
                  100 * largest_change(intrinsics.force), 100 * largest_change(intrinsics.rate),
                  force_on_rate));
  if (intrinsics.force_bias.isZero(0) && intrinsics.rate_bias.isZero(0)) return;
  recording.remarks.push_back(
      fmt::format("biases of the calibration are subtracted: {:.3g} m/s^2 and {:.3g} rad/s",
                  intrinsics.force_bias.norm(), intrinsics.rate_bias.norm()));
}

}  // namespace chasles
