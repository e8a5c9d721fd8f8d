#include <algorithm>
#include <cmath>
#include <iterator>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/camera/track_noise.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/session/batch_report.hpp>
#include <chasles/session/calibration_report.hpp>
#include <chasles/session/diagnosis.hpp>
#include <chasles/session/inertial_settings_io.hpp>
#include <chasles/session/recognition_report.hpp>
#include <chasles/session/run_figures.hpp>
#include <chasles/session/summary.hpp>
#include <chasles/session/truth_options.hpp>
#include <chasles/velocity/level_axes.hpp>
#include <chasles/velocity/velocity_model.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

Json numbers(const Eigen::Ref<const Eigen::VectorXd>& v) {
  return std::vector<double>(v.begin(), v.end());
}

Json stereo_json(const StereoNoise& noise) {
  return {
      {"pixel_sigma_u", noise.u}, {"pixel_sigma_v", noise.v}, {"disparity_sigma", noise.disparity}};
}

// Vectors have the components along the IMU's x, y and z axes.
Json noise_json(const VelocitySlamNoise& noise, bool level, double time_offset) {
  return {{"rate_sigma", numbers(noise.motion.sample_sigma.head<3>())},
          {"velocity_sigma", numbers(noise.motion.sample_sigma.tail<3>())},
          {"rate_walk", numbers(noise.motion.walk.head<3>())},
          {"velocity_walk", numbers(noise.motion.walk.tail<3>())},
          {"gyro_bias_sigma", noise.gyro_bias_sigma},
          {"gyro_bias_walk", noise.motion.gyro_bias_walk},
          {"velocity_axes", level ? "level" : "imu"},
          {"time_offset", time_offset},
          {"begin_landmark", stereo_json(noise.initialisation)},
          {"update", stereo_json(noise.update)}};
}

Json frontend_json(const FrontendTotals& t) {
  Json json = {{"frames", t.frames},
               {"unreadable", t.unreadable},
               {"tracked", t.tracked},
               {"added", t.added},
               {"lost", t.lost},
               {"outliers", t.outliers},
               {"stereo_tried", t.stereo_tried},
               {"stereo_matched", t.stereo_matched}};
  // Where only camera 0 finds tracks, `added` says it.
  const bool others = std::ranges::count_if(t.added_by_camera, [](long n) { return n > 0; }) > 1;
  if (others) json["added_by_camera"] = t.added_by_camera;
  return json;
}

// Whether the run treats the velocities as level; never in other modes or with an input.
bool are_level(const VelocitySensors& sensors, const VelocityRunSettings& settings) {
  return model_of(settings.filter, sensors.noise).level;
}

// Adds a remark if level axes were detected, not set.
void add_axes(const VelocitySensors& sensors, const VelocityRunSettings& settings,
              const Recording& recording, std::vector<std::string>& remarks) {
  if (!are_level(sensors, settings) || settings.filter.velocity_axes != VelocityAxes::kAuto) return;
  const LevelEvidence evidence = level_evidence(recording.velocities).value();
  remarks.push_back(fmt::format(
      "the velocities are along level axes, not the IMU's: their climb angle follows the pitch of "
      "the angular rates with a slope of {:.2f} +- {:.2f} (0 or less along the IMU's axes); "
      "velocity_axes=imu overrides this",
      evidence.slope, evidence.sigma));
}

Json or_null(const std::optional<double>& figure) { return figure ? Json(*figure) : Json(); }

Json noise_json(const ImuNoise& noise, double pixel_sigma, const InertialSlamSettings& filter) {
  return {{"pixel_sigma", pixel_sigma},
          {"track_sigma", filter.track_sigma.value_or(pixel_sigma)},
          {"track_drift", filter.track_drift.value_or(0)},
          {"match_sigma", filter.match_sigma.value_or(0)},
          {"imu_noise_scale", filter.imu_noise_scale.value_or(1)},
          {"vibration_noise", filter.vibration_noise.value_or(0)},
          {"accelerometer_noise_density", noise.accelerometer_noise_density},
          {"accelerometer_random_walk", noise.accelerometer_random_walk},
          {"gyroscope_noise_density", noise.gyroscope_noise_density},
          {"gyroscope_random_walk", noise.gyroscope_random_walk}};
}

Json imu_json(const ImuBuffer::Counts& imu) {
  return {{"used", imu.used},
          {"not_finite", imu.not_finite},
          {"not_later", imu.not_later},
          {"zero", imu.zero},
          {"spikes", imu.spikes},
          {"frozen", imu.frozen},
          {"interpolated", imu.interpolated},
          {"gaps", imu.gaps},
          {"saturated", imu.saturated},
          {"extrapolated", imu.extrapolated}};
}

Json degradations_json(const std::map<Degradation, int>& degradations) {
  Json json = Json::object();
  for (const Degradation degradation : {Degradation::kFewObservations, Degradation::kRejections,
                                        Degradation::kInnovations, Degradation::kUnknownSpeed}) {
    const auto found = degradations.find(degradation);
    json[name(degradation)] = found == degradations.end() ? 0 : found->second;
  }
  if (const auto found = degradations.find(Degradation::kLens); found != degradations.end()) {
    json[name(Degradation::kLens)] = found->second;
  }
  return json;
}

void append_degradations(const RecordedRun& run, std::vector<std::string>& remarks) {
  const auto reason = [](Degradation degradation) {
    switch (degradation) {
      case Degradation::kFewObservations:
        return std::string("the last second used fewer than 3 observations");
      case Degradation::kRejections:
        return std::string("the last second rejected more observations than it used");
      case Degradation::kUnknownSpeed:
        return std::string(
            "the sigma of the speed is above 1 m/s and above half of the speed, although the "
            "images have tracks");
      case Degradation::kLens:
        return std::string("the lens is not the stated one (see the remark on it)");
      default:
        return fmt::format(
            "the innovations of the last second had a NIS of more than {:g} per "
            "degree of freedom: the noise is stated too small, or the model is wrong",
            kMostNisPerDof);
    }
  };
  for (const auto& [degradation, frames] : run.degradations) {
    remarks.push_back(fmt::format("degraded in {} of {} frames: {}", frames, run.run.states.size(),
                                  reason(degradation)));
  }
}

void append_run_remarks(const RunReport& report, std::vector<std::string>& remarks) {
  const EstimatorReport& own = report.estimator;
  if (report.frontend.unreadable > 0) {
    remarks.push_back(fmt::format("{} frames have an unreadable image, which counts as missing",
                                  report.frontend.unreadable));
  }
  if (own.dropped_frames > 0) {
    remarks.push_back(fmt::format(
        "{} frames dropped: out of order, duplicate, or without IMU samples", own.dropped_frames));
  }
  if (own.imu.saturated > 0) {
    remarks.push_back(fmt::format(
        "{} IMU samples at the edge of the sensor's range: bridged with increased noise",
        own.imu.saturated));
  }
  const int left_out = own.imu.zero + own.imu.spikes + own.imu.frozen + own.imu.interpolated;
  if (left_out > 0) {
    remarks.push_back(fmt::format(
        "{} IMU samples are no measurements and were left out: {} of six zeros, {} spikes, {} of a "
        "sensor that repeats its numbers, {} interpolated",
        left_out, own.imu.zero, own.imu.spikes, own.imu.frozen, own.imu.interpolated));
  }
  if (own.batch) append_remarks(*own.batch, remarks);
  if (own.window) append_remarks(*own.window, remarks);
  if (own.resets > 0 && own.window) {
    remarks.push_back(
        fmt::format("the IMU has no samples for more than 0.5 s in {} places: the window ended "
                    "there, and started again at its last pose",
                    own.resets));
  } else if (own.resets > 0) {
    remarks.push_back(fmt::format("the filter was lost and restarted {} times", own.resets));
  }
}

void append_coverage(const RecordedRun& run, const Recording& recording,
                     std::vector<std::string>& remarks) {
  const EstimatorReport& own = run.report.estimator;
  const std::string remark = coverage_remark(run.coverage, {.start_seconds = run.start_seconds,
                                                            .resets = own.resets,
                                                            .dropped_frames = own.dropped_frames});
  if (remark.empty()) return;
  const bool checked = !run.report.interrupted;  // who interrupts does not wait for a check
  remarks.push_back(checked ? remark + "; " + finding_of_check(recording) : remark);
}

// The share of the frames in percent, rounded down: 100 only if all were estimated.
std::string coverage_text(const Json& summary) {
  const auto share = summary.find("coverage");
  if (share == summary.end() || !share->is_number()) return {};
  return fmt::format(" ({:.0f} % of the recording's)", std::floor(100 * share->get<double>()));
}

std::string line(const Json& summary, const char* label, const char* figure, const char* unit,
                 int digits) {
  const auto value = summary.find(figure);
  if (value == summary.end() || !value->is_number()) return {};
  return fmt::format("  {:<26} {:>10.{}f} {}\n", label, value->get<double>(), digits, unit);
}

// With --truth-errors auto.
std::string without_truth_errors(const Json& summary) {
  const auto errors = summary.find("truth_errors");
  if (errors == summary.end()) return {};
  const auto nees = [&](const char* figure, const char* dof) {
    return line(errors->at(figure), "  errors of truth removed", "mean", dof, 2);
  };
  const Json& time = errors->at("position_time_s");
  return nees("nees_pose", "(pose)") + nees("nees_position", "(position)") +
         nees("nees_attitude", "(attitude)") +
         fmt::format("  {:<26} {:>10.1f} ms, sigma {:.1f}\n", "  its positions are late",
                     1e3 * time.at("value").get<double>(), 1e3 * time.at("sigma").get<double>()) +
         line(errors->at("first_heading_deg"), "  heading of its first pose", "value", "deg", 2);
}

// The axis with the smallest share stands for the six.
std::string within_3_sigma(const Json& summary) {
  std::optional<double> least;
  std::string axis;
  for (const char* name : {"rx", "ry", "rz", "x", "y", "z"}) {
    const auto share = summary.find(fmt::format("within_3_sigma_{}", name));
    if (share == summary.end() || !share->is_number()) continue;
    if (least && *least <= share->get<double>()) continue;
    least = share->get<double>();
    axis = name;
  }
  if (!least) return {};
  return fmt::format("  {:<26} {:>10.2f} {}\n", "poses within 3 sigma", 100 * *least,
                     fmt::format("% on the worst axis, {} (consistent: 99.73)", axis));
}

}  // namespace

Json summary_json(const RecordedRun& run, const InertialRunSettings& settings,
                  const InertialSensors& sensors, const Recording& recording) {
  const EstimatorReport& report = run.report.estimator;
  std::vector<std::string> remarks = recording.remarks;
  append_run_remarks(run.report, remarks);
  append_degradations(run, remarks);
  append_coverage(run, recording, remarks);
  if (run.calibration) {
    std::ranges::move(calibration_remarks(*run.calibration, recording.cameras, settings.filter),
                      std::back_inserter(remarks));
  }
  Json summary = run_json(run.run, run.coverage, "slam", settings.filter.chart,
                          recording.true_landmarks, remarks, run.truth_attitudes);
  summary["degraded_frames"] = degradations_json(run.degradations);
  summary["nees_state"] = or_null(run.nees_state);
  summary["innovation_correlation"] = or_null(run.innovation_correlation);
  summary["truth_tilt_deg"] = or_null(run.truth_tilt_deg);
  summary["start_seconds"] = or_null(run.start_seconds);
  summary["initialised_seconds"] = or_null(run.initialised_seconds);
  summary["resets"] = report.resets;
  if (report.resets > 0 && summary["health"] == "ok") summary["health"] = "degraded";
  summary["zupt_frames"] = run.zupt_frames;
  summary["dropped_frames"] = report.dropped_frames;
  if (settings.filter.recognise == Recognise::kAppearance) {
    summary.update(recognition_json(report, run.run, run.has_prior_map));
  }
  if (recording.images) summary["frontend"] = frontend_json(run.report.frontend);
  if (report.batch) summary["batch"] = batch_json(*report.batch);
  if (report.window) summary["window"] = window_json(*report.window);
  summary["settings"] = settings_json(settings);
  const InertialSlamSettings decided_filter = decided(settings, recording).filter;
  summary["keep_scale"] = decided_filter.keep_scale == Toggle::kTrue;
  summary["scale_sigma"] = or_null(run.scale_sigma);
  if (run.calibration) {
    summary["calibration"] = calibration_json(*run.calibration, recording.cameras, settings.filter);
  }
  summary["noise"] = noise_json(
      sensors.noise, decided_filter.pixel_sigma.value_or(sensors.pixel_sigma), decided_filter);
  summary["imu"] = imu_json(report.imu);
  summary["cameras"] = cameras_json(recording);
  summary["remarks"] = remarks;
  return summary;
}

Json summary_json(const RecordedRun& run, const VelocityCommandSettings& settings,
                  const VelocitySensors& sensors, double time_offset, const Recording& recording) {
  const EstimatorReport& report = run.report.estimator;
  std::vector<std::string> remarks = recording.remarks;
  add_axes(sensors, settings, recording, remarks);
  if (report.batch) append_remarks(*report.batch, remarks);
  append_degradations(run, remarks);
  append_coverage(run, recording, remarks);
  Json summary =
      run_json(run.run, run.coverage, std::string(name_of(settings.filter.mode)),
               settings.filter.chart, recording.true_landmarks, remarks, run.truth_attitudes);
  summary["degraded_frames"] = degradations_json(run.degradations);
  VelocityCommandSettings copy = settings;
  if (report.batch) summary["batch"] = batch_json(*report.batch);
  if (report.window) summary["window"] = window_json(*report.window);
  summary["settings"] = to_json(setting_list(copy.filter));
  summary["settings"].update(to_json(setting_list(copy.reader)));
  if (!settings.estimator.is_filter()) {
    summary["settings"].update(to_json(setting_list(copy.batch)));
  }
  summary["noise"] = noise_json(sensors.noise, are_level(sensors, settings), time_offset);
  summary["cameras"] = cameras_json(recording);
  summary["remarks"] = remarks;
  return summary;
}

Json known_json(const InertialRunSettings& settings, const Recording& recording) {
  Json known = {{"version", CHASLES_VERSION}, {"mode", "slam"}, {"chart", settings.filter.chart}};
  known.update(pairing_json(recording.pairing));
  known["settings"] = settings_json(settings);
  known["cameras"] = cameras_json(recording);
  return known;
}

Json known_json(const VelocityCommandSettings& settings, const Recording& recording) {
  VelocitySlamSettings copy = settings.filter;
  Json known = {{"version", CHASLES_VERSION},
                {"mode", name_of(settings.filter.mode)},
                {"chart", settings.filter.chart}};
  known.update(pairing_json(recording.pairing));
  known["settings"] = to_json(setting_list(copy));
  known["cameras"] = cameras_json(recording);
  return known;
}

Json timing_json(const RecordedRun& run, double recorded_seconds, double wall_seconds, double cpu) {
  Json timing = {{"seconds_wall", wall_seconds},
                 {"seconds_cpu", cpu},
                 {"realtime_factor", recorded_seconds / wall_seconds}};
  const RunReport& report = run.report;
  const auto frames = static_cast<double>(run.run.states.size());
  if (report.frontend.frames > 0) {
    timing["frontend_ms_per_frame"] = 1e3 * report.frontend.seconds / report.frontend.frames;
  }
  timing["filter_ms_per_frame"] =
      frames > 0 ? Json(1e3 * report.estimator_seconds / frames) : Json();
  if (report.estimator.batch) append_timing(*report.estimator.batch, timing);
  if (report.estimator.window) append_timing(*report.estimator.window, timing);
  if (run.realtime) timing["realtime"] = realtime_json(*run.realtime);
  return timing;
}

std::string summary_text(const Json& summary) {
  std::string text =
      fmt::format("{}: {} frames{} in {:.1f} s, {} landmarks, health {}\n\n",
                  summary.at("name").get<std::string>(), summary.at("frames").get<long>(),
                  coverage_text(summary), summary.at("recorded_seconds").get<double>(),
                  summary.at("landmarks").get<long>(), summary.at("health").get<std::string>());
  text += line(summary, "ATE, SE(3)-aligned", "ate_m", "m", 3);
  text += line(summary, "ATE, yaw and position", "ate_posyaw_m", "m", 3);
  text += line(summary, "ATE, first pose", "ate_first_pose_m", "m", 3);
  text += line(summary, "attitude", "attitude_deg", "deg", 3);
  if (const auto smoothed = summary.find("smoothed"); smoothed != summary.end()) {
    text += line(*smoothed, "ATE of the smoothed path", "ate_m", "m", 3);
  }
  text += recognition_text(summary);
  text += line(summary, "RPE over 100 m", "rpe_100m_percent", "%", 3);
  text += line(summary, "tilt of the truth", "truth_tilt_deg", "deg, removed", 2);
  text += line(summary, "NEES of the pose", "nees_pose", "(consistent: 6)", 2);
  text += line(summary, "NEES of the position", "nees_position", "(consistent: 3)", 2);
  text += line(summary, "NEES of the attitude", "nees_attitude", "(consistent: 3)", 2);
  text += without_truth_errors(summary);
  text += within_3_sigma(summary);
  text += line(summary, "NIS per degree of freedom", "nis_per_dof", "(consistent: 1)", 3);
  text += line(summary, "landmarks", "landmarks_rmse_m", "m rmse", 3);
  text += line(summary, "time", "seconds_wall", "s", 2);
  text += line(summary, "processor time", "seconds_cpu", "s", 2);
  text += line(summary, "speed", "realtime_factor", "x real time", 1);
  for (const Json& remark : summary.at("remarks")) {
    text += fmt::format("\n- {}", remark.get<std::string>());
  }
  return text + (summary.at("remarks").empty() ? "" : "\n");
}

}  // namespace chasles
