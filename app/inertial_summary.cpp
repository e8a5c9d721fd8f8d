#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "batch_report.hpp"
#include "calibration_report.hpp"
#include "inertial_drive.hpp"
#include "inertial_setup.hpp"
#include "realtime.hpp"
#include "summary.hpp"

// What summary.json and timing.json say of a run with an IMU.
namespace chasles::app {
namespace {

using Json = nlohmann::ordered_json;

Json frontend_json(const FrontendTotals& t) {
  return {{"frames", t.frames},
          {"unreadable", t.unreadable},
          {"tracked", t.tracked},
          {"added", t.added},
          {"lost", t.lost},
          {"outliers", t.outliers},
          {"stereo_tried", t.stereo_tried},
          {"stereo_matched", t.stereo_matched}};
}

}  // namespace

Json known_json(const InertialRunSettings& settings, const Recording& recording) {
  return {{"version", CHASLES_VERSION},
          {"mode", "slam"},
          {"chart", settings.filter.chart},
          {"settings", settings_json(settings)},
          {"cameras", cameras_json(recording)}};
}

Json timing_json(const InertialDrive& drive, const Json& timing) {
  Json all = timing;
  const auto frames = static_cast<double>(drive.run.states.size());
  if (drive.frontend.frames > 0) {
    all["frontend_ms_per_frame"] = 1e3 * drive.frontend.seconds / drive.frontend.frames;
  }
  all["filter_ms_per_frame"] = frames > 0 ? Json(1e3 * drive.filter_seconds / frames) : Json();
  if (drive.batch) append_timing(*drive.batch, all);
  if (drive.window) append_timing(*drive.window, all);
  if (drive.realtime) all["realtime"] = realtime_json(*drive.realtime);
  return all;
}

Json summary_json(const InertialDrive& drive, const InertialRunSettings& settings,
                  const Recording& recording) {
  std::vector<std::string> remarks = recording.remarks;
  if (drive.frontend.unreadable > 0) {
    remarks.push_back(fmt::format("{} frames with an image that cannot be read: taken as missing",
                                  drive.frontend.unreadable));
  }
  if (drive.dropped_frames > 0) {
    remarks.push_back(fmt::format("{} frames late, there twice, or without IMU samples: dropped",
                                  drive.dropped_frames));
  }
  if (drive.imu.saturated > 0) {
    remarks.push_back(
        fmt::format("{} IMU samples at the edge of the sensor's range: bridged, with more noise",
                    drive.imu.saturated));
  }
  if (drive.batch) append_remarks(*drive.batch, remarks);
  if (drive.resets > 0) {
    remarks.push_back(fmt::format("the filter was lost and began anew {} times", drive.resets));
  }
  Json summary =
      run_json(drive.run, "slam", settings.filter.chart, recording.true_landmarks, remarks);
  summary["nees_state"] = drive.nees_state ? Json(*drive.nees_state) : Json();
  summary["innovation_correlation"] =
      drive.innovation_correlation ? Json(*drive.innovation_correlation) : Json();
  summary["start_seconds"] = drive.start_seconds ? Json(*drive.start_seconds) : Json();
  summary["resets"] = drive.resets;
  summary["zupt_frames"] = drive.zupt_frames;
  summary["dropped_frames"] = drive.dropped_frames;
  if (recording.images) summary["frontend"] = frontend_json(drive.frontend);
  if (drive.batch) summary["batch"] = batch_json(*drive.batch);
  if (drive.window) summary["window"] = window_json(*drive.window);
  summary["settings"] = settings_json(settings);
  summary["keep_scale"] = filter_settings(recording, settings).keep_scale == KeepScale::kTrue;
  if (drive.calibration) {
    summary["calibration"] =
        calibration_json(*drive.calibration, recording.cameras, settings.filter.time_offset);
  }
  const ImuNoise& noise = drive.imu_noise;
  summary["noise"] = {{"pixel_sigma", drive.pixel_sigma},
                      {"accelerometer_noise_density", noise.accelerometer_noise_density},
                      {"accelerometer_random_walk", noise.accelerometer_random_walk},
                      {"gyroscope_noise_density", noise.gyroscope_noise_density},
                      {"gyroscope_random_walk", noise.gyroscope_random_walk}};
  const ImuBuffer::Counts& imu = drive.imu;
  summary["imu"] = {{"used", imu.used},           {"not_finite", imu.not_finite},
                    {"not_later", imu.not_later}, {"gaps", imu.gaps},
                    {"saturated", imu.saturated}, {"extrapolated", imu.extrapolated}};
  summary["cameras"] = cameras_json(recording);
  summary["remarks"] = remarks;
  return summary;
}

}  // namespace chasles::app
