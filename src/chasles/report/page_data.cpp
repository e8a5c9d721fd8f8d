#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/eval/chi2.hpp>
#include <chasles/report/against_truth.hpp>
#include <chasles/report/columns.hpp>
#include <chasles/report/map_data.hpp>
#include <chasles/report/page_data.hpp>
#include <chasles/report/page_images.hpp>
#include <chasles/report/scenes.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

void add_poses(Json& columns, const std::vector<RunState>& states, const Eigen::Vector3d& origin) {
  const Time start = states.empty() ? Time{} : states.front().time;
  columns["t"] = floats(states, [&](const RunState& s) { return to_seconds(s.time - start); });
  add_points(columns, "", states,
             [&](const RunState& s) -> Eigen::Vector3d { return s.world_T_imu.p - origin; });
  std::vector<Eigen::Vector4d> quaternions;
  for (const RunState& s : states) {
    quaternions.push_back(Eigen::Quaterniond(s.world_T_imu.R).coeffs());
  }
  const std::array<const char*, 4> names = {"qx", "qy", "qz", "qw"};
  for (std::size_t k = 0; k < names.size(); ++k) {
    columns[names[k]] = floats(quaternions, [&](const Eigen::Vector4d& q) { return q(k); });
  }
}

void add_uncertainty(Json& columns, const std::vector<RunState>& states) {
  const auto difference = [](const RunState& s) -> Vector6d {
    return s.pose_covariance.diagonal().cwiseMax(0).cwiseSqrt();
  };
  add_covariances(columns, states, [](const RunState& s) -> Eigen::Matrix3d {
    return s.pose_covariance.bottomRightCorner<3, 3>();
  });
  add_points(columns, "sigma_p", states,
             [&](const RunState& s) -> Eigen::Vector3d { return difference(s).tail<3>(); });
  add_points(columns, "sigma_r", states, [&](const RunState& s) -> Eigen::Vector3d {
    return kDegrees * difference(s).head<3>();
  });
}

/// The 95 % interval of NIS / dof, for the degrees of freedom of the frame.
Band nis_band(const RunState& state) {
  if (state.nis_dof <= 0) return {.low = std::nan(""), .high = std::nan("")};
  const Band band = chi2_band(state.nis_dof, 1);
  return {.low = band.low / state.nis_dof, .high = band.high / state.nis_dof};
}

void add_updates(Json& columns, const std::vector<RunState>& states) {
  columns["nis"] = floats(states, [](const RunState& s) { return s.nis; });
  columns["nis_dof"] = ints(states, [](const RunState& s) { return s.nis_dof; });
  columns["nis_low"] = floats(states, [](const RunState& s) { return nis_band(s).low; });
  columns["nis_high"] = floats(states, [](const RunState& s) { return nis_band(s).high; });
  columns["observations"] = ints(states, [](const RunState& s) { return s.observations; });
  columns["used"] = ints(states, [](const RunState& s) { return s.used; });
  columns["rejected"] = ints(states, [](const RunState& s) { return s.rejected; });
  columns["in_state"] = ints(states, [](const RunState& s) { return s.in_state; });
  columns["landmarks"] = ints(states, [](const RunState& s) { return s.landmarks; });
  columns["milliseconds"] = floats(states, [](const RunState& s) { return s.milliseconds; });
}

/// The names of health that occur, in the order of their first occurrence.
std::vector<std::string> health_names(const std::vector<RunState>& states) {
  std::vector<std::string> names;
  for (const RunState& s : states) {
    if (std::find(names.begin(), names.end(), s.health) == names.end()) names.push_back(s.health);
  }
  return names;
}

void add_health(Json& json, const std::vector<RunState>& states) {
  const std::vector<std::string> names = health_names(states);
  json["health_names"] = names;
  json["states"]["health"] = ints(states, [&](const RunState& s) {
    return static_cast<int>(std::find(names.begin(), names.end(), s.health) - names.begin());
  });
}

Json extra_columns(const Run& run) {
  Json list = Json::array();
  for (std::size_t k = 0; k < run.extra_names.size(); ++k) {
    const auto entry = [k](const std::vector<double>& v) {
      return k < v.size() ? v[k] : std::nan("");
    };
    list.push_back(
        {{"value", floats(run.states, [&](const RunState& s) { return entry(s.extra); })},
         {"sigma", floats(run.states, [&](const RunState& s) { return entry(s.extra_sigma); })}});
  }
  return list;
}

Json stage_columns(const Run& run) {
  Json list = Json::array();
  for (std::size_t k = 0; k < run.stage_names.size(); ++k) {
    list.push_back(floats(run.states, [k](const RunState& s) {
      return k < s.stages.size() ? s.stages[k] : std::nan("");
    }));
  }
  return list;
}

void add_landmarks(Json& json, const Run& run, const Eigen::Vector3d& origin) {
  std::vector<RunLandmark> drawn;
  std::set<LandmarkId> of_map;  // map_json() has them
  if (run.prior_map) {
    for (const SketchPoint& point : run.prior_map->points) of_map.insert(point.id);
  }
  std::size_t left_out = 0;
  for (const RunLandmark& mark : run.landmarks) {
    if (of_map.contains(mark.id)) continue;
    if (mark.p_world.allFinite() && mark.covariance.allFinite()) {
      drawn.push_back(mark);
    } else {
      ++left_out;
    }
  }
  std::vector<double> ids;
  for (const RunLandmark& mark : drawn) ids.push_back(static_cast<double>(mark.id));
  Json& columns = json["landmarks"];
  columns["id"] = double_column(ids);
  add_points(columns, "", drawn,
             [&](const RunLandmark& m) -> Eigen::Vector3d { return m.p_world - origin; });
  add_covariances(columns, drawn, [](const RunLandmark& m) { return m.covariance; });
  columns["observations"] = ints(drawn, [](const RunLandmark& m) { return m.observations; });
  // Computed like the states' times, so that the same instant is the same number.
  const Time start = run.states.empty() ? Time{} : run.states.front().time;
  columns["first"] =
      floats(drawn, [&](const RunLandmark& m) { return to_seconds(m.first_seen - start); });
  columns["last"] =
      floats(drawn, [&](const RunLandmark& m) { return to_seconds(m.last_seen - start); });
  columns["in_state"] = ints(drawn, [](const RunLandmark& m) { return m.in_state ? 1 : 0; });
  if (std::ranges::any_of(drawn, [](const RunLandmark& m) { return m.initial.has_value(); })) {
    constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
    add_points(columns, "i", drawn, [&](const RunLandmark& m) -> Eigen::Vector3d {
      if (!m.initial) return Eigen::Vector3d::Constant(kNan);
      return m.initial->p_world - origin;
    });
  }
  json["landmarks_left_out"] = left_out;
}

/// The coordinates in which the run's chart assumes a Gaussian error: those of its NEES.
PoseError nees_coordinates(const Json& summary) {
  const auto chart = summary.find("chart");
  if (chart == summary.end() || !chart->is_string()) return PoseError::kStandard;
  return pose_error_of(chart->get<std::string>());
}

void add_truth(Json& json, const Run& run, const AgainstTruth& errors,
               const Eigen::Vector3d& origin) {
  json["nees_coordinates"] = name(errors.nees.definition);
  const Trajectory truth = thinned(run.truth);
  const auto placed = [&](const SE3& world_T_truth) {
    return [&origin, world_T_truth](const StampedPose& s) -> Eigen::Vector3d {
      return world_T_truth * s.pose.p - origin;
    };
  };
  json["truth_problem"] = errors.problem;
  add_points(json["truth"], "first_", truth, placed(errors.world_T_truth_first));
  add_points(json["truth"], "fit_", truth, placed(errors.world_T_truth_fit));
  if (!errors.problem.empty()) return;
  Json& columns = json["errors"];
  add_points(columns, "attitude_", errors.error,
             [](const Vector6d& e) -> Eigen::Vector3d { return kDegrees * e.head<3>(); });
  add_points(columns, "position_", errors.error,
             [](const Vector6d& e) -> Eigen::Vector3d { return e.tail<3>(); });
  columns["nees_pose"] = float_column(errors.nees_pose);
  columns["nees_attitude"] = float_column(errors.nees_attitude);
  columns["nees_position"] = float_column(errors.nees_position);
}

/// The height at which the plan is drawn: that of the first true pose, else of the first estimate.
double plan_height(const Run& run) {
  if (!run.truth.empty()) return run.truth.front().pose.p.z();
  const double first = run.states.empty() ? 0 : run.states.front().world_T_imu.p.z();
  return std::isfinite(first) ? first : 0;
}

/// The lines of a floor plan of one kind, in the run's world: with the truth aligned by the first
/// pose, and by the best fit. NaN ends a line. Without a truth the run's world is the plan's.
Json plan_columns(const Run& run, PlanLine::Kind kind, const AgainstTruth& errors,
                  const Eigen::Vector3d& origin) {
  const double height = plan_height(run);
  std::vector<Eigen::Vector3d> corners;
  for (const PlanLine& line : run.plan) {
    if (line.kind != kind) continue;
    for (const Eigen::Vector2d& p : line.points) corners.emplace_back(p.x(), p.y(), height);
    corners.emplace_back(Eigen::Vector3d::Constant(std::nan("")));
  }
  Json columns;
  for (const auto& [prefix, world_T_truth] :
       {std::pair{"first_", errors.world_T_truth_first}, {"fit_", errors.world_T_truth_fit}}) {
    add_points(columns, prefix, corners,
               [&, &placed = world_T_truth](const Eigen::Vector3d& p) -> Eigen::Vector3d {
                 return placed * p - origin;
               });
  }
  return columns;
}

void add_plan(Json& json, const Run& run, const AgainstTruth& errors,
              const Eigen::Vector3d& origin) {
  // A truth that cannot be compared does not place the plan.
  const bool is_placed = run.truth.empty() || errors.problem.empty();
  if (run.plan.empty() || !is_placed) return;
  json["plan"] = {{"wall", plan_columns(run, PlanLine::Kind::kWall, errors, origin)},
                  {"furniture", plan_columns(run, PlanLine::Kind::kFurniture, errors, origin)}};
}

Json parsed_summary(const ReportRun& run) {
  if (run.summary.empty()) return Json::object();
  Json summary = Json::parse(run.summary, nullptr, false);
  if (!summary.is_object()) {
    throw InputError(
        fmt::format("the summary of run '{}' is not a json object; write the run again "
                    "with `chasles run`",
                    run.run.name));
  }
  return summary;
}

}  // namespace

Json run_data(const ReportRun& report_run, Json summary, const AgainstTruth& errors) {
  const Run& run = report_run.run;
  const Eigen::Vector3d first =
      run.states.empty() ? Eigen::Vector3d::Zero() : run.states.front().world_T_imu.p;
  const Eigen::Vector3d origin = first.allFinite() ? first : Eigen::Vector3d::Zero();

  Json json = {{"name", run.name}, {"label", report_run.label}, {"summary", std::move(summary)}};
  json["level"] = is_level(run);
  json["origin"] = {origin.x(), origin.y(), origin.z()};
  add_poses(json["states"], run.states, origin);
  add_uncertainty(json["states"], run.states);
  add_updates(json["states"], run.states);
  add_health(json, run.states);
  json["extra_names"] = run.extra_names;
  json["extra"] = extra_columns(run);
  json["stage_names"] = run.stage_names;
  json["stages"] = stage_columns(run);
  add_landmarks(json, run, origin);
  if (run.prior_map && !run.prior_map->points.empty()) json["map"] = map_json(run, origin);
  if (!run.truth.empty()) add_truth(json, run, errors, origin);
  add_plan(json, run, errors, origin);
  if (!run.dead_reckoning.empty()) {
    add_points(json["dead_reckoning"], "", thinned(run.dead_reckoning),
               [&](const StampedPose& s) -> Eigen::Vector3d { return s.pose.p - origin; });
  }
  return json;
}

Json page_bounds() {
  Json json;
  for (const int dof : {3, 6}) {
    const Band band = chi2_band(dof, 1);
    json[fmt::format("chi2_{}_low", dof)] = band.low;
    json[fmt::format("chi2_{}_high", dof)] = band.high;
  }
  return json;
}

Json page_data(const std::vector<ReportRun>& runs) {
  Json json = {{"bounds", page_bounds()}};
  std::vector<Json> summaries;
  std::vector<AgainstTruth> errors;
  for (const ReportRun& run : runs) {
    summaries.push_back(parsed_summary(run));
    errors.push_back(against_truth(run.run, nees_coordinates(summaries.back())));
  }
  json["scenes"] = scenes_json(runs, errors);
  json["runs"] = Json::array();
  for (std::size_t i = 0; i < runs.size(); ++i) {
    json["runs"].push_back(run_data(runs[i], std::move(summaries[i]), errors[i]));
    json["runs"].back()["images"] = images_json(runs[i].run, kPagePictures / runs.size());
  }
  return json;
}

}  // namespace chasles
