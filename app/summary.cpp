#include "summary.hpp"

#include <algorithm>
#include <unordered_map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/error.hpp>
#include <chasles/eval/landmarks.hpp>
#include <chasles/imu/level_axes.hpp>
#include <chasles/slam/velocity_model.hpp>

#include "batch_report.hpp"
#include "filter_options.hpp"

namespace chasles::app {
namespace {

using Json = nlohmann::ordered_json;

Json numbers(const Eigen::Ref<const Eigen::VectorXd>& v) {
  return std::vector<double>(v.begin(), v.end());
}

Json stereo_json(const StereoNoise& noise) {
  return {
      {"pixel_sigma_u", noise.u}, {"pixel_sigma_v", noise.v}, {"disparity_sigma", noise.disparity}};
}

// Three numbers are those of the IMU's x, y and z.
Json noise_json(const VelocitySlamNoise& noise, bool level, double time_offset) {
  return {{"rate_sigma", numbers(noise.motion.sample_sigma.head<3>())},
          {"velocity_sigma", numbers(noise.motion.sample_sigma.tail<3>())},
          {"rate_walk", numbers(noise.motion.walk.head<3>())},
          {"velocity_walk", numbers(noise.motion.walk.tail<3>())},
          {"gyro_bias_sigma", noise.gyro_bias_sigma},
          {"gyro_bias_walk", noise.motion.gyro_bias_walk},
          {"velocity_axes", level ? "level" : "imu"},
          {"time_offset", time_offset},
          {"begin_landmark", stereo_json(noise.begin)},
          {"update", stereo_json(noise.update)}};
}

Json counts_json(const Run& run) {
  long observations = 0, used = 0, rejected = 0, dof = 0, degraded = 0;
  double nis = 0;
  for (const RunState& s : run.states) {
    observations += s.observations;
    used += s.used;
    rejected += s.rejected;
    dof += s.nis_dof;
    nis += s.nis;
    degraded += s.health != "ok";
  }
  const double length =
      run.states.empty() ? 0 : to_seconds(run.states.back().time - run.states.front().time);
  return {{"health", run_health(run.states)},
          {"frames", run.states.size()},
          {"frames_not_ok", degraded},
          {"recorded_seconds", length},
          {"landmarks", run.landmarks.size()},
          {"observations", observations},
          {"used", used},
          {"rejected", rejected},
          {"nis_per_dof", dof > 0 ? Json(nis / static_cast<double>(dof)) : Json()}};
}

Json no_evaluation() {
  Json json = Json::object();
  for (const auto& [name, value] : figures(Evaluation{})) json[name] = nullptr;
  return json;
}

std::string line(const Json& summary, const char* label, const char* figure, const char* unit,
                 int digits) {
  const auto value = summary.find(figure);
  if (value == summary.end() || !value->is_number()) return {};
  return fmt::format("  {:<26} {:>10.{}f} {}\n", label, value->get<double>(), digits, unit);
}

}  // namespace

std::string run_health(const std::vector<RunState>& states) {
  const auto count = [&](const char* health) {
    return static_cast<std::size_t>(std::ranges::count(states, health, &RunState::health));
  };
  if (!states.empty() && states.back().health == "lost") return "lost";
  return count("lost") > 0 || 10 * count("degraded") > states.size() ? "degraded" : "ok";
}

Json figures_json(const Evaluation& evaluation) {
  Json json = Json::object();
  for (const auto& [name, value] : figures(evaluation)) json[name] = value ? Json(*value) : Json();
  return json;
}

// The true landmarks among the map's, by id; null where there are none, or where the trajectories
// are not comparable.
Json landmarks_json(const Run& run, const std::vector<TrueLandmark>& truths, bool comparable) {
  std::unordered_map<LandmarkId, Eigen::Vector3d> p_truth;
  for (const TrueLandmark& truth : truths) p_truth.emplace(truth.id, truth.p_world);
  std::vector<MatchedPoint> points;
  for (const RunLandmark& landmark : run.landmarks) {
    const auto truth = p_truth.find(landmark.id);
    if (truth != p_truth.end()) {
      points.push_back({.p_estimate = landmark.p_world, .p_truth = truth->second});
    }
  }
  Json json{{"landmarks_matched", points.size()},
            {"landmarks_rmse_m", nullptr},
            {"landmarks_rmse_aligned_m", nullptr}};
  if (points.empty() || !comparable) return json;
  Trajectory estimate;
  for (const RunState& s : run.states) estimate.push_back({.time = s.time, .pose = s.world_T_imu});
  const LandmarkError error = landmark_error(
      points, align(associate(estimate, run.truth), Alignment::kFirstPose).truth_T_estimate);
  json["landmarks_rmse_m"] = error.rmse_first_pose_m;
  if (error.rmse_aligned_m) json["landmarks_rmse_aligned_m"] = *error.rmse_aligned_m;
  return json;
}

Json evaluation_json(const Run& run, const std::string& chart, std::vector<std::string>& remarks) {
  if (run.truth.empty() || run.states.empty()) return no_evaluation();
  Trajectory estimate;
  std::vector<Matrix6d> covariances;
  for (const RunState& s : run.states) {
    estimate.push_back({.time = s.time, .pose = s.world_T_imu});
    covariances.push_back(s.pose_covariance);
  }
  EvaluationOptions options;
  options.pose_error = pose_error_of(chart);
  options.level = is_level(run);
  try {
    return figures_json(evaluate(estimate, run.truth, covariances, options));
  } catch (const InputError& error) {
    remarks.push_back(fmt::format("not evaluated: {}", error.what()));
    return no_evaluation();
  }
}

Json run_json(const Run& run, const std::string& mode, const std::string& chart,
              const std::vector<TrueLandmark>& true_landmarks, std::vector<std::string>& remarks) {
  Json json = {{"name", run.name}, {"version", CHASLES_VERSION}, {"mode", mode}, {"chart", chart}};
  json.update(counts_json(run));
  json.update(evaluation_json(run, chart, remarks));
  json.update(landmarks_json(run, true_landmarks, !json["ate_m"].is_null()));
  if (run.georeference) {
    const Geodetic& origin = run.georeference->origin;
    json["georeference"] = {{"latitude", origin.latitude},
                            {"longitude", origin.longitude},
                            {"altitude", origin.altitude}};
  }
  return json;
}

Json cameras_json(const Recording& recording) {
  Json list = Json::array();
  const auto add = [&](const SE3& cam_T_imu, const auto& camera) -> Json& {
    const SE3 imu_T_cam = cam_T_imu.inverse();
    Json rows = Json::array();
    for (int i = 0; i < 3; ++i) {
      rows.push_back({imu_T_cam.R(i, 0), imu_T_cam.R(i, 1), imu_T_cam.R(i, 2), imu_T_cam.p(i)});
    }
    rows.push_back({0, 0, 0, 1});
    list.push_back(
        {{"imu_T_cam", rows}, {"intrinsics", {camera.fx, camera.fy, camera.cx, camera.cy}}});
    return list.back();
  };
  for (const Camera& camera : recording.cameras) {
    add(camera.cam_T_imu, camera)["resolution"] = {camera.width, camera.height};
  }
  if (recording.cameras.empty()) {
    const StereoRig& rig = recording.rig;
    const SE3 cam1_T_cam0{Eigen::Matrix3d::Identity(), {-rig.baseline, 0, 0}};
    add(rig.cam0_T_imu, rig);
    add(cam1_T_cam0 * rig.cam0_T_imu, rig);
  }
  return list;
}

// Taken as such by the run; in other modes and of an input they are not.
bool are_level(const Drive& drive, const DriveRunSettings& settings) {
  return model_of(settings.filter, drive.noise).level;
}

// Where it was found, not said.
void add_axes(const Drive& drive, const DriveRunSettings& settings, const Recording& recording,
              std::vector<std::string>& remarks) {
  if (!are_level(drive, settings) || settings.filter.velocity_axes != VelocityAxes::kAuto) return;
  const LevelEvidence evidence = level_evidence(recording.velocities).value();
  remarks.push_back(fmt::format(
      "the velocities are along level axes, not the IMU's: they climb by {:.2f} +- {:.2f} of what "
      "the rates pitch it (0 or less along its own axes); velocity_axes=imu takes them as its own",
      evidence.slope, evidence.sigma));
}

Json summary_json(const Drive& drive, const DriveRunSettings& settings,
                  const Recording& recording) {
  std::vector<std::string> remarks = recording.remarks;
  add_axes(drive, settings, recording, remarks);
  if (drive.batch) append_remarks(*drive.batch, remarks);
  Json summary = run_json(drive.run, std::string(name_of(settings.filter.mode)),
                          settings.filter.chart, recording.true_landmarks, remarks);
  DriveRunSettings copy = settings;
  if (drive.batch) summary["batch"] = batch_json(*drive.batch);
  if (drive.window) summary["window"] = window_json(*drive.window);
  summary["settings"] = to_json(setting_list(copy.filter));
  if (drive.batch || drive.window) summary["settings"].update(to_json(setting_list(copy.batch)));
  summary["noise"] = noise_json(drive.noise, are_level(drive, settings), drive.time_offset);
  summary["cameras"] = cameras_json(recording);
  summary["remarks"] = remarks;
  return summary;
}

Json known_json(const VelocitySlamSettings& settings, const Recording& recording) {
  VelocitySlamSettings copy = settings;
  return {{"version", CHASLES_VERSION},
          {"mode", settings.mode},
          {"chart", settings.chart},
          {"settings", to_json(setting_list(copy))},
          {"cameras", cameras_json(recording)}};
}

Json timing_json(double recorded_seconds, double wall_seconds, double cpu) {
  return {{"seconds_wall", wall_seconds},
          {"seconds_cpu", cpu},
          {"realtime_factor", recorded_seconds / wall_seconds}};
}

std::string summary_text(const Json& summary) {
  std::string text =
      fmt::format("{}: {} frames in {:.1f} s, {} landmarks, health {}\n\n",
                  summary.at("name").get<std::string>(), summary.at("frames").get<long>(),
                  summary.at("recorded_seconds").get<double>(), summary.at("landmarks").get<long>(),
                  summary.at("health").get<std::string>());
  text += line(summary, "ATE, SE(3)-aligned", "ate_m", "m", 3);
  text += line(summary, "ATE, yaw and position", "ate_posyaw_m", "m", 3);
  text += line(summary, "ATE, first pose", "ate_first_pose_m", "m", 3);
  text += line(summary, "attitude", "attitude_deg", "deg", 3);
  text += line(summary, "RPE over 100 m", "rpe_100m_percent", "%", 3);
  text += line(summary, "NEES of the pose", "nees_pose", "(consistent: 6)", 2);
  text += line(summary, "NEES of the position", "nees_position", "(consistent: 3)", 2);
  text += line(summary, "NEES of the attitude", "nees_attitude", "(consistent: 3)", 2);
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

}  // namespace chasles::app
