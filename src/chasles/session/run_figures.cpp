#include <algorithm>
#include <cstdlib>
#include <unordered_map>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/eval/association.hpp>
#include <chasles/eval/landmarks.hpp>
#include <chasles/session/run_figures.hpp>
#include <chasles/session/truth_options.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

Json counts_json(const Run& run, const FrameCoverage& coverage) {
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
  return {{"health", run_health(run.states, coverage)},
          {"frames", run.states.size()},
          {"coverage", coverage.share()},
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

// Errors of the landmarks, matched to the true ones by id; null without matches, or if the
// trajectories are not comparable.
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
      points,
      align(associate(estimate, run.truth, run.pairing), Alignment::kFirstPose).truth_T_estimate);
  json["landmarks_rmse_m"] = error.rmse_first_pose_m;
  if (error.rmse_aligned_m) json["landmarks_rmse_aligned_m"] = *error.rmse_aligned_m;
  return json;
}

template <class Pose>
std::pair<Trajectory, std::vector<Matrix6d>> poses_of(const std::vector<Pose>& poses) {
  std::pair<Trajectory, std::vector<Matrix6d>> result;
  result.first.reserve(poses.size());
  result.second.reserve(poses.size());
  for (const Pose& pose : poses) {
    result.first.push_back({.time = pose.time, .pose = pose.world_T_imu});
    result.second.push_back(pose.pose_covariance);
  }
  return result;
}

EvaluationOptions evaluation_options(const Run& run, const std::string& chart, bool attitudes) {
  EvaluationOptions options;
  options.pose_error = pose_error_of(chart);
  options.level = is_level(run);
  options.pairing = run.pairing;
  options.attitudes = attitudes;
  return options;
}

Json smoothed_json(const Run& run, const std::string& chart, bool attitudes) {
  const auto [estimate, covariances] = poses_of(run.smoothed);
  Json json = {{"frames", estimate.size()}};
  json.update(figures_json(
      evaluate(estimate, run.truth, covariances, evaluation_options(run, chart, attitudes))));
  return json;
}

// OpenBLAS's kernels round differently, so the variable changes the last digits of all results.
void add_kernels(Json& json, std::vector<std::string>& remarks) {
  const char* kernels = std::getenv("OPENBLAS_CORETYPE");
  if (kernels == nullptr) return;
  json["openblas_coretype"] = valid_utf8(kernels);
  remarks.push_back(fmt::format(
      "OPENBLAS_CORETYPE={} was set: without it the last digits may differ", valid_utf8(kernels)));
}

}  // namespace

std::string run_health(const std::vector<RunState>& states, const FrameCoverage& coverage) {
  const auto count = [&](const char* health) {
    return static_cast<std::size_t>(std::ranges::count(states, health, &RunState::health));
  };
  if (!states.empty() && states.back().health == "lost") return "lost";
  const bool unreliable = count("lost") > 0 || 10 * count("degraded") > states.size();
  return unreliable || coverage.share() < kLeastCoverage ? "degraded" : "ok";
}

Json figures_json(const Evaluation& evaluation) {
  Json json = Json::object();
  for (const auto& [name, value] : figures(evaluation)) json[name] = value ? Json(*value) : Json();
  return json;
}

Json evaluation_json(const Run& run, const std::string& chart, bool attitudes,
                     std::vector<std::string>& remarks) {
  if (run.truth.empty() || run.states.empty()) return no_evaluation();
  const auto [estimate, covariances] = poses_of(run.states);
  try {
    return figures_json(
        evaluate(estimate, run.truth, covariances, evaluation_options(run, chart, attitudes)));
  } catch (const InputError& error) {
    remarks.push_back(fmt::format("not evaluated: {}", error.what()));
    return no_evaluation();
  }
}

Json run_json(const Run& run, const FrameCoverage& coverage, const std::string& mode,
              const std::string& chart, const std::vector<TrueLandmark>& true_landmarks,
              std::vector<std::string>& remarks, bool truth_attitudes) {
  Json json = {{"name", run.name}, {"version", CHASLES_VERSION}, {"mode", mode}, {"chart", chart}};
  json.update(counts_json(run, coverage));
  json.update(evaluation_json(run, chart, truth_attitudes, remarks));
  json.update(pairing_json(run.pairing));
  if (!truth_attitudes) json["truth_attitudes"] = false;
  json.update(landmarks_json(run, true_landmarks, !json["ate_m"].is_null() && truth_attitudes));
  if (!run.smoothed.empty() && !json["ate_m"].is_null()) {
    json["smoothed"] = smoothed_json(run, chart, truth_attitudes);
  }
  add_kernels(json, remarks);
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
  for (std::size_t c = 0; c < recording.cameras.size(); ++c) {
    const Camera& camera = recording.cameras[c];
    Json& entry = add(camera.cam_T_imu, camera);
    entry["resolution"] = {camera.width, camera.height};
    if (!recording.camera_numbers.empty()) entry["number"] = recording.camera_numbers[c];
  }
  if (recording.cameras.empty()) {
    const StereoRig& rig = recording.rig;
    const SE3 cam1_T_cam0{Eigen::Matrix3d::Identity(), {-rig.baseline, 0, 0}};
    add(rig.cam0_T_imu, rig);
    add(cam1_T_cam0 * rig.cam0_T_imu, rig);
  }
  return list;
}

}  // namespace chasles
