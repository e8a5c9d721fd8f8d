#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/check/camera_fit.hpp>
#include <chasles/pipeline/measured_offset.hpp>
#include <chasles/session/inertial_settings_io.hpp>
#include <chasles/session/motion_calibration.hpp>

namespace chasles {
namespace {

// Turns the rig so that its first camera is mounted as the gyroscope says.
void mount_by_rotations(const SessionOptions& options, Recording& recording,
                        const StopRequest& stop) {
  const InertialRunSettings settings = inertial_run_settings_from(options.settings);
  const std::vector<FeatureFrame> tracks =
      tracks_of_first_camera(recording, settings.frontend, kExaminedSeconds, stop);
  const std::optional<CameraFit> fit =
      fit_camera(tracks, recording.cameras, 0, gyroscope_rates(recording.imu));
  if (!fit || !fit->gyroscope || fit->gyroscope->mirrored || !fit->agrees()) {
    throw InputError(fmt::format(
        "{}: the rotations of the images do not show how the camera is mounted: expected turns "
        "about two axes, and a lens and rates that are right (`chasles check`)",
        recording.name));
  }
  const SE3 first_T_imu = recording.cameras[0].cam_T_imu;
  const SE3 mounted{fit->gyroscope->cam_R_imu, Eigen::Vector3d::Zero()};
  for (Camera& camera : recording.cameras) {
    camera.cam_T_imu = camera.cam_T_imu * first_T_imu.inverse() * mounted;
  }
}

std::vector<Eigen::MatrixXd> lens_covariances(const Calibration& found) {
  std::vector<Eigen::MatrixXd> result;
  int first = found.intrinsics_row();
  for (const Intrinsics& one : found.intrinsics) {
    std::vector<int> rows = {first, first + 1, first + 2, first + 3};
    for (int k = 0; k < static_cast<int>(one.coefficients.size()); ++k) {
      rows.push_back(first + 6 + k);
    }
    result.emplace_back(found.covariance(rows, rows));
    first += 6 * one.blocks();
  }
  return result;
}

}  // namespace

MotionCalibration calibrate_from_motion(const SessionOptions& options, Recording& recording,
                                        bool from_nothing, const StopRequest& stop) {
  if (recording.imu.empty() || recording.cameras.empty()) {
    throw InputError(fmt::format("{}: found {} IMU samples and {} cameras, expected both",
                                 recording.name, recording.imu.size(), recording.cameras.size()));
  }
  if (from_nothing) mount_by_rotations(options, recording, stop);
  SessionOptions run = options;
  run.settings.estimator = {.kind = EstimatorChoice::Kind::kBatch};
  run.settings.sets.insert(
      run.settings.sets.begin(),
      {"calibrate_extrinsics=true", "calibrate_intrinsics=true", "calibrate_time_offset=true",
       "initial_extrinsic_rotation_sigma=0.2", "initial_extrinsic_translation_sigma=0.1"});
  RunObserver nobody;
  const CompletedRun done = plan_run(run, recording)(stop).run(nobody);
  if (!done.result.calibration) {
    throw Error(ExitCode::kNotInitialised,
                fmt::format("{}: the run ended without a calibration", recording.name));
  }
  const Calibration& found = *done.result.calibration;
  MotionCalibration result{.cameras = recording.cameras,
                           .time_offset = found.time_offset.value_or(0),
                           .parameters = done.summary.at("calibration").at("parameters"),
                           .lens_covariances = lens_covariances(found),
                           .remarks = recording.remarks};
  for (std::size_t c = 0; c < result.cameras.size(); ++c) {
    Camera& camera = result.cameras[c];
    if (!found.intrinsics.empty()) camera = with_intrinsics(camera, found.intrinsics[c]);
    if (!found.imu_T_camera.empty()) camera.cam_T_imu = found.imu_T_camera[c].inverse();
  }
  return result;
}

nlohmann::ordered_json motion_json(const MotionCalibration& calibration) {
  return {{"parameters", calibration.parameters}, {"remarks", calibration.remarks}};
}

std::string motion_text(const MotionCalibration& calibration) {
  std::string text =
      fmt::format("{:<28}{:>14}{:>14}{:>12}\n", "parameter", "stated", "estimate", "sigma");
  for (const nlohmann::ordered_json& one : calibration.parameters) {
    const std::string unit = one.value("unit", "");
    text += fmt::format("{:<28}{:>14.6g}{:>14.6g}{:>12.3g} {}\n", one.at("name").get<std::string>(),
                        one.at("stated").get<double>(), one.at("estimate").get<double>(),
                        one.at("sigma").get<double>(), unit);
  }
  for (const std::string& remark : calibration.remarks) text += "- " + remark + "\n";
  return text;
}

}  // namespace chasles
