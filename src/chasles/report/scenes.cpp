#include <algorithm>
#include <cstddef>

#include <nlohmann/json.hpp>

#include <chasles/constants.hpp>
#include <chasles/eval/alignment.hpp>
#include <chasles/report/columns.hpp>
#include <chasles/report/scenes.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kEnough = 2500;  // points of a drawn trajectory

/// A state of a run, placed on the truth.
struct PlacedState {
  double seconds = 0;                    ///< since the truth's first
  Eigen::Vector3d p_truth_world, error;  ///< error: less the true position
  double nees_pose = 0;
};

struct Scene {
  const Run* first = nullptr;  ///< the run whose truth and plan are used
  std::vector<std::size_t> runs;
};

bool same_way(const Trajectory& a, const Trajectory& b) {
  return std::ranges::equal(a, b, [](const StampedPose& u, const StampedPose& v) {
    return u.time == v.time && u.pose.p == v.pose.p;
  });
}

std::vector<Scene> scenes_of(const std::vector<ReportRun>& runs,
                             const std::vector<AgainstTruth>& errors) {
  std::vector<Scene> scenes;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (!errors[i].problem.empty()) continue;  // the run's own part of the page gives the reason
    const Run& run = runs[i].run;
    auto scene = std::ranges::find_if(
        scenes, [&](const Scene& s) { return same_way(s.first->truth, run.truth); });
    if (scene == scenes.end()) scene = scenes.insert(scene, {.first = &run, .runs = {}});
    if (scene->first->plan.empty()) scene->first = &run;  // any of the runs may have the plan
    scene->runs.push_back(i);
  }
  std::erase_if(scenes, [](const Scene& s) { return s.runs.size() < 2 && s.first->plan.empty(); });
  return scenes;
}

std::vector<PlacedState> placed(const Run& run, const AgainstTruth& errors) {
  const MatchedTrajectories& matched = errors.matched;
  const Alignment fit = is_level(run) ? Alignment::kPositionYaw : Alignment::kRigid;
  const SE3 truth_T_world = align(matched, fit).truth_T_estimate;
  std::vector<PlacedState> states;
  for (std::size_t i = 0; i < matched.estimate.size(); ++i) {
    const Eigen::Vector3d p = truth_T_world * matched.estimate[i].pose.p;
    states.push_back({.seconds = to_seconds(matched.estimate[i].time - run.truth.front().time),
                      .p_truth_world = p,
                      .error = p - matched.truth[i].pose.p,
                      .nees_pose = errors.nees.pose[i]});
  }
  return states;
}

Json run_json(std::size_t index, const Run& run, const AgainstTruth& errors,
              const Eigen::Vector3d& origin) {
  const std::vector<PlacedState> states = thinned(placed(run, errors), kEnough);
  Json json;
  add_points(json, "", states,
             [&](const PlacedState& s) -> Eigen::Vector3d { return s.p_truth_world - origin; });
  add_points(json, "e", states, [](const PlacedState& s) { return s.error; });
  json["t"] = double_column(values<double>(states, [](const PlacedState& s) { return s.seconds; }));
  json["nees"] = floats(states, [](const PlacedState& s) { return s.nees_pose; });
  json["run"] = index;
  json["mean_nees"] = {{"position", errors.nees.position_summary.mean},
                       {"attitude", errors.nees.attitude_summary.mean},
                       {"pose", errors.nees.pose_summary.mean}};
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

Json scene_json(const Scene& scene, const std::vector<ReportRun>& runs,
                const std::vector<AgainstTruth>& errors) {
  const Run& first = *scene.first;
  const Eigen::Vector3d origin = first.truth.front().pose.p;
  Json json = {{"name", first.name}, {"origin", {origin.x(), origin.y(), origin.z()}}};
  add_points(json["truth"], "", thinned(first.truth, kEnough),
             [&](const StampedPose& s) -> Eigen::Vector3d { return s.pose.p - origin; });
  json["plan"] = {{"wall", plan_json(first.plan, PlanLine::Kind::kWall, origin)},
                  {"furniture", plan_json(first.plan, PlanLine::Kind::kFurniture, origin)}};
  json["runs"] = Json::array();
  for (const std::size_t i : scene.runs) {
    json["runs"].push_back(run_json(i, runs[i].run, errors[i], origin));
  }
  return json;
}

}  // namespace

Json scenes_json(const std::vector<ReportRun>& runs, const std::vector<AgainstTruth>& errors) {
  Json json = Json::array();
  for (const Scene& scene : scenes_of(runs, errors)) {
    json.push_back(scene_json(scene, runs, errors));
  }
  return json;
}

}  // namespace chasles
