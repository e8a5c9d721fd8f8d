#include <algorithm>
#include <cstddef>

#include <nlohmann/json.hpp>

#include <chasles/base/constants.hpp>
#include <chasles/eval/alignment.hpp>
#include <chasles/report/columns.hpp>
#include <chasles/report/scenes.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kEnough = 2500;  // points of a drawn trajectory

/// A state of a run, placed on the truth; without a truth, in the run's world, which is the plan's.
struct PlacedState {
  double seconds = 0;              ///< since the truth's first, else the run's
  Eigen::Vector3d p_scene, error;  ///< error: less the true position
  double nees_pose = 0;
};

struct Scene {
  const Run* first = nullptr;  ///< the run whose truth and plan are used
  std::vector<std::size_t> runs;

  bool has_truth() const { return !first->truth.empty(); }
};

bool same_way(const Trajectory& a, const Trajectory& b) {
  return std::ranges::equal(a, b, [](const StampedPose& u, const StampedPose& v) {
    return u.time == v.time && u.pose.p == v.pose.p;
  });
}

bool same_plan(const Plan& a, const Plan& b) {
  return std::ranges::equal(a, b, [](const PlanLine& u, const PlanLine& v) {
    return u.kind == v.kind && u.points == v.points;
  });
}

bool same_scene(const Run& a, const Run& b) {
  if (a.truth.empty() || b.truth.empty()) {
    return a.truth.empty() && b.truth.empty() && same_plan(a.plan, b.plan);
  }
  return same_way(a.truth, b.truth);
}

std::vector<Scene> scenes_of(const std::vector<ReportRun>& runs,
                             const std::vector<AgainstTruth>& errors) {
  std::vector<Scene> scenes;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const Run& run = runs[i].run;
    // Where the truth does not fit, the run's own part of the page gives the reason.
    if (run.truth.empty() ? run.plan.empty() : !errors[i].problem.empty()) continue;
    auto scene =
        std::ranges::find_if(scenes, [&](const Scene& s) { return same_scene(*s.first, run); });
    if (scene == scenes.end()) scene = scenes.insert(scene, {.first = &run, .runs = {}});
    if (scene->first->plan.empty()) scene->first = &run;  // any of the runs may have the plan
    scene->runs.push_back(i);
  }
  std::erase_if(scenes, [](const Scene& s) { return s.runs.size() < 2 && s.first->plan.empty(); });
  return scenes;
}

std::vector<PlacedState> without_truth(const Run& run) {
  std::vector<PlacedState> states;
  for (const RunState& s : run.states) {
    if (!s.world_T_imu.p.allFinite()) continue;
    states.push_back({.seconds = to_seconds(s.time - run.states.front().time),
                      .p_scene = s.world_T_imu.p,
                      .error = Eigen::Vector3d::Constant(kNaN),
                      .nees_pose = kNaN});
  }
  return states;
}

std::vector<PlacedState> placed(const Run& run, const AgainstTruth& errors) {
  const MatchedTrajectories& matched = errors.matched;
  const Alignment fit = is_level(run) ? Alignment::kPositionYaw : Alignment::kRigid;
  const SE3 truth_T_world = align(matched, fit).truth_T_estimate;
  std::vector<PlacedState> states;
  for (std::size_t i = 0; i < matched.estimate.size(); ++i) {
    const Eigen::Vector3d p = truth_T_world * matched.estimate[i].pose.p;
    states.push_back({.seconds = to_seconds(matched.estimate[i].time - run.truth.front().time),
                      .p_scene = p,
                      .error = p - matched.truth[i].pose.p,
                      .nees_pose = errors.nees.pose[i]});
  }
  return states;
}

Json run_json(std::size_t index, const Run& run, const AgainstTruth& errors,
              const Eigen::Vector3d& origin) {
  const bool has_truth = !run.truth.empty();
  const std::vector<PlacedState> states =
      thinned(has_truth ? placed(run, errors) : without_truth(run), kEnough);
  Json json;
  add_points(json, "", states,
             [&](const PlacedState& s) -> Eigen::Vector3d { return s.p_scene - origin; });
  json["t"] = double_column(values<double>(states, [](const PlacedState& s) { return s.seconds; }));
  json["run"] = index;
  if (!has_truth) return json;
  add_points(json, "e", states, [](const PlacedState& s) { return s.error; });
  json["nees"] = floats(states, [](const PlacedState& s) { return s.nees_pose; });
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

Eigen::Vector3d origin_of(const Scene& scene) {
  const Run& first = *scene.first;
  if (scene.has_truth()) return first.truth.front().pose.p;
  const Eigen::Vector3d start =
      first.states.empty() ? Eigen::Vector3d::Zero() : first.states.front().world_T_imu.p;
  return start.allFinite() ? start : Eigen::Vector3d::Zero();
}

Json scene_json(const Scene& scene, const std::vector<ReportRun>& runs,
                const std::vector<AgainstTruth>& errors) {
  const Run& first = *scene.first;
  const Eigen::Vector3d origin = origin_of(scene);
  Json json = {{"name", first.name}, {"origin", {origin.x(), origin.y(), origin.z()}}};
  if (scene.has_truth()) {
    add_points(json["truth"], "", thinned(first.truth, kEnough),
               [&](const StampedPose& s) -> Eigen::Vector3d { return s.pose.p - origin; });
  }
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
