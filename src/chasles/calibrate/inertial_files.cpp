#include <tuple>

#include <Eigen/LU>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/inertial_files.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/utf8.hpp>

namespace chasles {
namespace {

// Without g-sensitivity.
ImuIntrinsics composed(const ImuCorrection& correction, const ImuIntrinsics& stated) {
  const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
  const Eigen::Matrix3d force = I + correction.force, rate = I + correction.rate;
  return {.force = force * stated.force,
          .rate = rate * stated.rate,
          .rate_of_force = rate * stated.rate_of_force * force.inverse(),
          .force_bias = force * stated.force_bias,
          .rate_bias = rate * stated.rate_bias};
}

}  // namespace

CalibrationToWrite with_found(CalibrationToWrite stated, const std::vector<Camera>& cameras,
                              const std::vector<double>& time_offsets, const ImuCorrection& imu) {
  CalibrationToWrite result = std::move(stated);
  result.cameras = cameras;
  result.time_offsets.resize(cameras.size(), 0);
  for (std::size_t c = 0; c < cameras.size(); ++c) result.time_offsets[c] += time_offsets[c];
  if (!imu.parameters().isZero(0)) {
    result.imu_intrinsics = composed(imu, result.imu_intrinsics.value_or(ImuIntrinsics{}));
  }
  return result;
}

void check_same_rig(const std::string& first, const CalibrationToWrite& of_first,
                    const std::string& other, const CalibrationToWrite& of_other) {
  const auto fail = [&](const char* what) {
    throw InputError(fmt::format(
        "{}: its calibration has another {} than that of {}: expected the same rig, with one "
        "calibration",
        other, what, first));
  };
  if (of_first.time_offsets != of_other.time_offsets) fail("time offset");
  if (of_first.imu_convention != of_other.imu_convention) fail("kind of IMU samples");
  const auto values = [](const CalibrationToWrite& calibration) {
    const ImuIntrinsics all = calibration.imu_intrinsics.value_or(ImuIntrinsics{});
    return std::tuple(all.force, all.rate, all.rate_of_force, all.force_bias, all.rate_bias);
  };
  if (values(of_first) != values(of_other)) fail("scale or axis of the IMU");
}

void write_inertial(InertialReport& report, const CalibrationToWrite& stated,
                    const std::filesystem::path& folder) {
  const InertialCalibration& found = report.calibration;
  const WrittenCalibration written =
      write_all(with_found(stated, found.cameras, found.time_offsets, found.imu), folder);
  report.remarks.insert(report.remarks.end(), written.left_out.begin(), written.left_out.end());
  replace_file(folder / "run.yaml", run_settings(found));
  replace_file(folder / "imu-cameras.json", json_text(inertial_json(report), 2) + "\n");
}

}  // namespace chasles
