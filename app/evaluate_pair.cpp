#include "evaluate_pair.hpp"

#include <array>
#include <cmath>
#include <string_view>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <spdlog/spdlog.h>

#include <chasles/base/error.hpp>
#include <chasles/base/time.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/eval/pair_difference.hpp>
#include <chasles/eval/table.hpp>
#include <chasles/run_folder/run.hpp>

namespace chasles::app {
namespace {

constexpr double kImplausible = 20;  // factor of runs of one recording
constexpr std::array<std::string_view, 6> kAxes{"rx", "ry", "rz", "x", "y", "z"};

EstimatedPath path_of(const Run& run) {
  EstimatedPath path;
  for (const RunState& s : run.states) {
    path.poses.push_back({.time = s.time, .pose = s.world_T_imu});
    path.covariances.push_back(s.pose_covariance);
  }
  return path;
}

void check_one_of_pair(const std::filesystem::path& folder, const nlohmann::ordered_json& summary) {
  const std::string mode = summary.value("mode", "slam");
  if (mode == "slam") return;
  throw UsageError(fmt::format("--pair: {}: found a run with mode {}, expected slam, from tracks",
                               folder.string(), mode));
}

bool have_no_track_in_common(const nlohmann::ordered_json& a, const nlohmann::ordered_json& b) {
  const auto of_a = a.find("tracks"), of_b = b.find("tracks");
  return of_a != a.end() && of_b != b.end() &&
         of_a->value("part", 0.0) == of_b->value("part", 0.0) &&
         of_a->value("seed", 0) == of_b->value("seed", 0) &&
         of_a->value("rest", false) != of_b->value("rest", false);
}

// What makes the comparison say less than it seems to.
void warn_of_conditions(const nlohmann::ordered_json& a, const nlohmann::ordered_json& b,
                        const Run& first, const Run& second) {
  if (!have_no_track_in_common(a, b)) {
    spdlog::warn(
        "the runs may share tracks, and a shared error is not in the difference: expected "
        "`--tracks "
        "PART`, and the same with --tracks-rest");
  }
  const double apart = to_seconds(second.states.front().time - first.states.front().time);
  if (std::abs(apart) > 1) {
    spdlog::warn("the runs start {:.1f} s apart: the error of the first common pose is left out",
                 std::abs(apart));
  }
}

bool is_overconfident(const PairDifference& d) { return d.factor() > kMostByChance; }

std::string sentence(const PairDifference& d) {
  if (is_overconfident(d)) {
    return fmt::format("the sigmas are too small, by a factor of about {:.1f} or more", d.factor());
  }
  return "the difference agrees with the covariances; errors that both share are not in it";
}

nlohmann::ordered_json json_of(const PairDifference& d) {
  nlohmann::ordered_json json = {
      {"compared", d.compared},           {"duration_s", d.duration_s},
      {"difference_m", d.position_rms_m}, {"difference_deg", d.attitude_rms_deg},
      {"nees_position", d.position.mean}, {"nees_attitude", d.attitude.mean},
      {"nees_pose", d.pose.mean},         {"nees_count", d.pose.count}};
  for (std::size_t i = 0; i < kAxes.size(); ++i) {
    json[fmt::format("within_3_sigma_{}", kAxes[i])] = d.within_3_sigma.share[i];
  }
  json["factor"] = d.factor();
  json["overconfident"] = is_overconfident(d);
  return json;
}

Table nees_table_of(const PairDifference& d) {
  Table table{.header = {"difference", "dof", "mean", "median", "within 95 %"}, .rows = {}};
  for (const auto& [name, s] :
       {std::pair("position", d.position), {"attitude", d.attitude}, {"pose", d.pose}}) {
    table.rows.push_back(
        {name, std::to_string(s.dof), cell(s.mean, 2), cell(s.median, 2), cell(100 * s.inside, 1)});
  }
  return table;
}

// An error of the association names the second run as the truth.
PairDifference difference_of(const std::filesystem::path& first,
                             const std::filesystem::path& second, const Run& a, const Run& b) {
  try {
    return pair_difference(path_of(a), path_of(b), is_level(a));
  } catch (const InputError& error) {
    throw InputError(fmt::format("--pair: {}, with {} in the place of a truth: {}", first.string(),
                                 second.string(), error.what()));
  }
}

}  // namespace

std::string evaluated_pair(const std::filesystem::path& first, const std::filesystem::path& second,
                           Form form) {
  if (second.empty()) {
    throw UsageError("--pair: expected two run folders, of the same recording and other tracks");
  }
  const Run a = read_run(first), b = read_run(second);
  if (is_level(a) != is_level(b)) {
    throw UsageError(fmt::format("--pair: {} has an IMU and {} has none, expected runs of one kind",
                                 (is_level(a) ? first : second).string(),
                                 (is_level(a) ? second : first).string()));
  }
  const auto summary_a = read_summary(first), summary_b = read_summary(second);
  check_one_of_pair(first, summary_a);
  check_one_of_pair(second, summary_b);
  if (a.name != b.name) {
    throw UsageError(
        fmt::format("--pair: found runs of {} and of {}, expected one recording", a.name, b.name));
  }
  if (!a.states.empty() && !b.states.empty()) warn_of_conditions(summary_a, summary_b, a, b);
  const PairDifference d = difference_of(first, second, a, b);
  if (d.factor() > kImplausible) {
    spdlog::warn(
        "the runs differ by {:.0f} times their sigmas: are both of one recording, played in one "
        "direction?",
        d.factor());
  }
  if (form == Form::kJson) return json_text(json_of(d), 2) + "\n";
  const std::string head =
      fmt::format("{} poses over {:.1f} s: they differ by {:.4f} m and {:.3f} deg (rms)",
                  d.compared, d.duration_s, d.position_rms_m, d.attitude_rms_deg);
  const Table table = nees_table_of(d);
  return fmt::format("{}\n\n{}\n{}\n", head,
                     form == Form::kMarkdown ? to_markdown(table) : to_text(table), sentence(d));
}

}  // namespace chasles::app
