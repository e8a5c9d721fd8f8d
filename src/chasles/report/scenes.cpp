#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include <chasles/error.hpp>
#include <chasles/eval/alignment.hpp>
#include <chasles/eval/association.hpp>
#include <chasles/eval/nees.hpp>
#include <chasles/report/encode.hpp>
#include <chasles/report/scenes.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kEnough = 2500;  // points of a way that is drawn
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// A run on the truth: times since the truth's first, positions, what they differ by, and NEES.
struct PlacedRun {
  std::size_t run = 0;
  bool level = false;
  std::vector<double> seconds, nees_pose;
  std::vector<Eigen::Vector3d> p_truth_world, error;
  PoseNees mean_nees;
};

struct Scene {
  const Run* first = nullptr;  ///< whose truth and plan it is
  std::vector<PlacedRun> runs;
};

bool same_way(const Trajectory& a, const Trajectory& b) {
  return std::ranges::equal(a, b, [](const StampedPose& u, const StampedPose& v) {
    return u.time == v.time && u.pose.p == v.pose.p;
  });
}

std::size_t stride_for(std::size_t rows) { return rows / kEnough + 1; }

/// The coordinates in which the run's chart calls an error Gaussian.
PoseError coordinates_of(const std::string& summary) {
  const Json json = Json::parse(summary, nullptr, false);
  if (!json.is_object()) return PoseError::kStandard;
  const auto chart = json.find("chart");
  const bool named = chart != json.end() && chart->is_string();
  return named ? pose_error_of(chart->get<std::string>()) : PoseError::kStandard;
}

void add_nees(const Run& run, const MatchedTrajectories& matched, PoseError coordinates,
              PlacedRun& result) {
  std::vector<Matrix6d> covariances;
  for (const RunState& state : run.states) covariances.push_back(state.pose_covariance);
  const Nees all = nees(matched, covariances, coordinates, result.level);
  result.mean_nees = {.position = all.position_summary.mean,
                      .attitude = all.attitude_summary.mean,
                      .pose = all.pose_summary.mean};
  const std::size_t stride = stride_for(all.pose.size());
  for (std::size_t i = 0; i < all.pose.size(); i += stride) {
    result.nees_pose.push_back(all.pose[i]);
  }
}

std::optional<PlacedRun> placed(const ReportRun& report_run, std::size_t index) {
  const Run& run = report_run.run;
  Trajectory estimate;
  for (const RunState& s : run.states) estimate.push_back({s.time, s.world_T_imu});
  PlacedRun result;
  result.run = index;
  result.level = is_level(run);
  try {
    const MatchedTrajectories matched = associate(estimate, run.truth);
    const Alignment fit = result.level ? Alignment::kPositionYaw : Alignment::kRigid;
    const SE3 truth_T_world = align(matched, fit).truth_T_estimate;
    const std::size_t stride = stride_for(matched.estimate.size());
    const Time begin = run.truth.front().time;
    for (std::size_t i = 0; i < matched.estimate.size(); i += stride) {
      result.seconds.push_back(to_seconds(matched.estimate[i].time - begin));
      result.p_truth_world.emplace_back(truth_T_world * matched.estimate[i].pose.p);
      result.error.emplace_back(result.p_truth_world.back() - matched.truth[i].pose.p);
    }
    add_nees(run, matched, coordinates_of(report_run.summary), result);
  } catch (const InputError&) {
    return std::nullopt;  // the run's own part of the page says why
  }
  return result;
}

std::vector<Scene> scenes_of(const std::vector<ReportRun>& runs) {
  std::vector<Scene> scenes;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Run& run = runs[i].run;
    auto on_truth = run.truth.empty() ? std::nullopt : placed(runs[i], i);
    if (!on_truth) continue;
    auto scene = std::ranges::find_if(
        scenes, [&](const Scene& s) { return same_way(s.first->truth, run.truth); });
    if (scene == scenes.end()) scene = scenes.insert(scene, {.first = &run, .runs = {}});
    if (scene->first->plan.empty()) scene->first = &run;  // any of them knows the plan
    scene->runs.push_back(std::move(*on_truth));
  }
  std::erase_if(scenes, [](const Scene& s) { return s.runs.size() < 2 && s.first->plan.empty(); });
  return scenes;
}

Json columns(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& origin,
             const std::string& prefix, Json json = Json::object()) {
  for (const auto& [axis, k] : {std::pair{"x", 0}, std::pair{"y", 1}, std::pair{"z", 2}}) {
    std::vector<double> values;
    for (const Eigen::Vector3d& p : points) values.push_back(p(k) - origin(k));
    json[prefix + axis] = float_column(values);
  }
  return json;
}

Json plan_json(const Plan& plan, PlanLine::Kind kind, const Eigen::Vector3d& origin) {
  std::vector<double> x, y;
  for (const PlanLine& line : plan) {
    if (line.kind != kind) continue;
    for (const Eigen::Vector2d& p : line.points) {
      x.push_back(p.x() - origin.x());
      y.push_back(p.y() - origin.y());
    }
    x.push_back(kNaN);
    y.push_back(kNaN);
  }
  return {{"x", float_column(x)}, {"y", float_column(y)}};
}

Json scene_json(const Scene& scene) {
  const Run& first = *scene.first;
  const Eigen::Vector3d origin = first.truth.front().pose.p;
  std::vector<Eigen::Vector3d> truth;
  const std::size_t stride = stride_for(first.truth.size());
  for (std::size_t i = 0; i < first.truth.size(); i += stride) {
    truth.push_back(first.truth[i].pose.p);
  }
  Json json = {{"name", first.name}, {"origin", {origin.x(), origin.y(), origin.z()}}};
  json["truth"] = columns(truth, origin, "");
  json["plan"] = {{"wall", plan_json(first.plan, PlanLine::Kind::kWall, origin)},
                  {"furniture", plan_json(first.plan, PlanLine::Kind::kFurniture, origin)}};
  json["runs"] = Json::array();
  for (const PlacedRun& run : scene.runs) {
    Json entry = columns(run.p_truth_world, origin, "");
    entry = columns(run.error, Eigen::Vector3d::Zero(), "e", std::move(entry));
    entry["t"] = double_column(run.seconds);
    entry["nees"] = float_column(run.nees_pose);
    entry["run"] = run.run;
    entry["level"] = run.level;
    entry["mean_nees"] = {{"position", run.mean_nees.position},
                          {"attitude", run.mean_nees.attitude},
                          {"pose", run.mean_nees.pose}};
    json["runs"].push_back(std::move(entry));
  }
  return json;
}

}  // namespace

Json scenes_json(const std::vector<ReportRun>& runs) {
  Json json = Json::array();
  for (const Scene& scene : scenes_of(runs)) json.push_back(scene_json(scene));
  return json;
}

}  // namespace chasles
