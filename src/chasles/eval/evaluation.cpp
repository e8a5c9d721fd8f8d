#include <array>
#include <cmath>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/eval/evaluation.hpp>
#include <chasles/eval/positions_only.hpp>

namespace chasles {
namespace {

using Figure = std::optional<double>;

Figure finite(double value) { return std::isfinite(value) ? Figure(value) : std::nullopt; }

Figure position(const Evaluation& evaluation, Alignment alignment) {
  const AbsoluteError* error = find(evaluation, alignment);
  return error ? finite(error->position_m.rmse) : std::nullopt;
}

Figure attitude(const Evaluation& evaluation, Alignment alignment) {
  const AbsoluteError* error = find(evaluation, alignment);
  return error ? finite(error->attitude_deg.rmse) : std::nullopt;
}

const RelativeError* of_length(const std::vector<RelativeError>& errors, double length) {
  for (const RelativeError& error : errors) {
    if (error.length == length) return &error;
  }
  return nullptr;
}

Figure mean_translation(const std::vector<RelativeError>& errors, double length) {
  const RelativeError* error = of_length(errors, length);
  return error ? finite(error->translation.mean) : std::nullopt;
}

Figure mean_rotation(const std::vector<RelativeError>& errors, double length) {
  const RelativeError* error = of_length(errors, length);
  return error ? finite(error->rotation.mean) : std::nullopt;
}

Figure mean_of(const Evaluation& evaluation, ConsistencySummary Nees::*summary) {
  return evaluation.nees ? finite(((*evaluation.nees).*summary).mean) : std::nullopt;
}

// The components of the standard pose error.
constexpr std::array kAxes{"rx", "ry", "rz", "x", "y", "z"};

void append(Table& table, const char* quantity, const ConsistencySummary& s) {
  table.rows.push_back({quantity, fmt::format("{}", s.dof), cell(s.mean, 2), cell(s.median, 2),
                        s.count > 0 ? fmt::format("{:.2f} to {:.2f}", s.band.low, s.band.high) : "",
                        cell(100 * s.inside, 1), fmt::format("{}", s.count),
                        fmt::format("{}", s.skipped)});
}

}  // namespace

Evaluation evaluate(const Trajectory& estimate, const Trajectory& truth,
                    std::span<const Matrix6d> covariances, const EvaluationOptions& options) {
  if (!covariances.empty() && covariances.size() != estimate.size()) {
    throw InputError(fmt::format("{} covariances for {} poses of the estimate, expected one a pose",
                                 covariances.size(), estimate.size()));
  }
  const MatchedTrajectories matched = associate(estimate, truth, options.pairing);
  Evaluation result;
  result.matched = matched.truth.size();
  result.interpolated = matched.interpolated;
  result.estimates = estimate.size();
  result.truths = truth.size();
  result.duration_s = to_seconds(matched.truth.back().time - matched.truth.front().time);
  result.path_m = path_length(matched.truth);
  for (const Alignment alignment : options.alignments) {
    const bool by_attitude =
        alignment == Alignment::kFirstPose || alignment == Alignment::kFirstLevel;
    if (by_attitude && !options.attitudes) continue;
    result.absolute.push_back(absolute_error(matched, alignment));
    if (!options.attitudes) result.absolute.back().attitude_deg = statistics({});
  }
  if (options.attitudes) {
    result.over_distance = relative_error_over_distance(matched, options.relative);
    result.over_time = relative_error_over_time(matched, options.relative);
  }
  if (!covariances.empty()) {
    result.nees = options.attitudes ? nees(matched, covariances, options.pose_error, options.level)
                                    : position_nees(matched, covariances, options.level);
  }
  return result;
}

const AbsoluteError* find(const Evaluation& evaluation, Alignment alignment) {
  for (const AbsoluteError& error : evaluation.absolute) {
    if (error.alignment == alignment) return &error;
  }
  return nullptr;
}

std::vector<std::pair<std::string, std::optional<double>>> figures(const Evaluation& e) {
  std::vector<std::pair<std::string, Figure>> all = {
      {"matched", static_cast<double>(e.matched)},
      {"path_m", e.path_m},
      {"duration_s", e.duration_s},
      {"ate_m", position(e, Alignment::kRigid)},
      {"ate_posyaw_m", position(e, Alignment::kPositionYaw)},
      {"ate_first_pose_m", position(e, Alignment::kFirstPose)},
      {"attitude_deg", attitude(e, Alignment::kRigid)},
      {"attitude_posyaw_deg", attitude(e, Alignment::kPositionYaw)},
      {"attitude_first_pose_deg", attitude(e, Alignment::kFirstPose)},
      {"rpe_100m_percent", mean_translation(e.over_distance, 100)},
      {"rpe_100m_deg_per_m", mean_rotation(e.over_distance, 100)},
      {"rpe_1s_m", mean_translation(e.over_time, 1)},
      {"rpe_1s_deg", mean_rotation(e.over_time, 1)},
      {"nees_position", mean_of(e, &Nees::position_summary)},
      {"nees_attitude", mean_of(e, &Nees::attitude_summary)},
      {"nees_pose", mean_of(e, &Nees::pose_summary)}};
  for (std::size_t i = 0; i < kAxes.size(); ++i) {
    all.emplace_back(fmt::format("within_3_sigma_{}", kAxes[i]),
                     e.nees ? finite(e.nees->within_3_sigma.share[i]) : std::nullopt);
  }
  return all;
}

Table absolute_table(const Evaluation& evaluation) {
  Table table{.header = {"alignment", "rmse m", "mean m", "median m", "max m", "attitude rmse deg",
                         "max deg"},
              .rows = {}};
  for (const AbsoluteError& e : evaluation.absolute) {
    table.rows.push_back({std::string(name(e.alignment)), cell(e.position_m.rmse, 3),
                          cell(e.position_m.mean, 3), cell(e.position_m.median, 3),
                          cell(e.position_m.max, 3), cell(e.attitude_deg.rmse, 3),
                          cell(e.attitude_deg.max, 3)});
  }
  return table;
}

Table distance_table(const Evaluation& evaluation) {
  Table table{.header = {"over m", "mean %", "rmse %", "mean deg/m", "pieces"}, .rows = {}};
  for (const RelativeError& e : evaluation.over_distance) {
    if (e.translation.count == 0) continue;
    table.rows.push_back({fmt::format("{:g}", e.length), cell(e.translation.mean, 3),
                          cell(e.translation.rmse, 3), cell(e.rotation.mean, 5),
                          fmt::format("{}", e.translation.count)});
  }
  return table;
}

Table time_table(const Evaluation& evaluation) {
  Table table{.header = {"over s", "mean m", "rmse m", "mean deg", "pieces"}, .rows = {}};
  for (const RelativeError& e : evaluation.over_time) {
    if (e.translation.count == 0) continue;
    table.rows.push_back({fmt::format("{:g}", e.length), cell(e.translation.mean, 4),
                          cell(e.translation.rmse, 4), cell(e.rotation.mean, 4),
                          fmt::format("{}", e.translation.count)});
  }
  return table;
}

Table nees_table(const Evaluation& evaluation) {
  Table table{.header = {"NEES", "dof", "mean", "median", "95 % band of the mean", "inside %",
                         "stamps", "skipped"},
              .rows = {}};
  if (!evaluation.nees) return table;
  append(table, "position", evaluation.nees->position_summary);
  const ConsistencySummary& pose = evaluation.nees->pose_summary;
  if (pose.count + pose.skipped == 0) return table;  // the truth has positions alone
  append(table, "attitude", evaluation.nees->attitude_summary);
  append(table, "pose", evaluation.nees->pose_summary);
  return table;
}

Table within_3_sigma_table(const Evaluation& evaluation) {
  Table table{.header = {"within 3 sigma %", "expected"}, .rows = {}};
  if (!evaluation.nees) return table;
  table.header.insert(table.header.end(), kAxes.begin(), kAxes.end());
  table.rows.push_back({"of the poses", "99.73"});
  for (const double share : evaluation.nees->within_3_sigma.share) {
    table.rows.back().push_back(cell(100 * share, 2));
  }
  return table;
}

std::string to_text(const Evaluation& evaluation) {
  std::string text = fmt::format(
      "{} stamps compared ({} of the estimate, {} of the truth{}), {:.1f} m in {:.1f} s\n\n",
      evaluation.matched, evaluation.estimates, evaluation.truths,
      evaluation.interpolated > 0
          ? fmt::format(", interpolated at {} stamps", evaluation.interpolated)
          : "",
      evaluation.path_m, evaluation.duration_s);
  text += to_text(absolute_table(evaluation));
  for (const Table& table : {distance_table(evaluation), time_table(evaluation),
                             nees_table(evaluation), within_3_sigma_table(evaluation)}) {
    if (!table.rows.empty()) text += '\n' + to_text(table);
  }
  return text;
}

}  // namespace chasles
