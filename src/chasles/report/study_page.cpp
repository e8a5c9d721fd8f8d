#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/report/columns.hpp>
#include <chasles/report/page_template.hpp>
#include <chasles/report/study.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

// All filters share one time axis: those that ended earlier have NaN after their end.
std::string padded(std::vector<double> values, std::size_t length) {
  values.resize(length, std::numeric_limits<double>::quiet_NaN());
  return float_column(values);
}

template <typename Rows, typename Number>
std::string floats(const Rows& rows, std::size_t length, const Number& number) {
  std::vector<double> values;
  for (const auto& row : rows) values.push_back(number(row));
  return padded(std::move(values), std::max(length, values.size()));
}

// x, y, z of points relative to the origin, so that single precision is accurate to a millimetre.
template <typename Rows, typename Point>
Json points(const Rows& rows, std::size_t length, const Eigen::Vector3d& origin,
            const Point& point) {
  Json columns;
  constexpr std::array names{"x", "y", "z"};
  for (int axis = 0; axis < 3; ++axis) {
    columns[names[static_cast<std::size_t>(axis)]] =
        floats(rows, length, [&](const auto& row) { return point(row)(axis) - origin(axis); });
  }
  return columns;
}

const auto position = [](const StampedPose& s) -> const Eigen::Vector3d& { return s.pose.p; };
const auto place = [](const TrueLandmark& mark) -> const Eigen::Vector3d& { return mark.p_world; };

Json curves_json(const StudyCurves& curves, std::size_t length, const Eigen::Vector3d& origin) {
  Json json{{"name", curves.filter},
            {"position_error", padded(curves.position_error, length)},
            {"attitude_error", padded(curves.attitude_error, length)},
            {"nees_position", padded(curves.nees_position, length)},
            {"nees_attitude", padded(curves.nees_attitude, length)},
            {"nees_pose", padded(curves.nees_pose, length)},
            {"nees_state", padded(curves.nees_state, length)}};
  if (!curves.estimate.empty()) {
    json["estimate"] = points(curves.estimate, length, origin, position);
  }
  if (!curves.landmarks.empty()) json["landmarks"] = points(curves.landmarks, 0, origin, place);
  return json;
}

// The number of runs that count for each filter determines the width of its band.
Json bands_json(std::size_t runs) {
  Json json{{"runs", runs}};
  for (const int dof : {3, 6, 15}) {
    const Band band = chi2_band(dof, std::max<std::size_t>(runs, 1));
    json[fmt::format("chi2_{}_low", dof)] = band.low;
    json[fmt::format("chi2_{}_high", dof)] = band.high;
  }
  return json;
}

std::size_t runs_that_count(const Study& study) {
  if (study.single_run) return 1;
  std::vector<std::size_t> counts(study.filters.size(), 0);
  for (const StudyTrial& trial : study.trials) counts[trial.filter] += trial.diverged ? 0 : 1;
  return counts.empty() ? 0 : *std::ranges::max_element(counts);
}

Json trials_json(const std::vector<StudyTrial>& trials) {
  std::vector<int> filters, diverged;
  std::vector<double> runs;
  for (const StudyTrial& trial : trials) {
    filters.push_back(static_cast<int>(trial.filter));
    diverged.push_back(trial.diverged ? 1 : 0);
    runs.push_back(static_cast<double>(trial.run));
  }
  const auto of = [&](double StudyTrial::*member) {
    return floats(trials, [&](const StudyTrial& trial) { return trial.*member; });
  };
  return {{"filter", int_column(filters)},
          {"diverged", int_column(diverged)},
          {"run", double_column(runs)},
          {"position_error", of(&StudyTrial::position_error)},
          {"attitude_error", of(&StudyTrial::attitude_error)},
          {"nees_position", of(&StudyTrial::nees_position)},
          {"nees_attitude", of(&StudyTrial::nees_attitude)},
          {"nees_pose", of(&StudyTrial::nees_pose)}};
}

Json study_json(const Study& study) {
  const auto longest = std::ranges::max_element(
      study.filters, {}, [](const StudyCurves& c) { return c.seconds.size(); });
  const std::size_t length = longest == study.filters.end() ? 0 : longest->seconds.size();
  const Eigen::Vector3d origin =
      study.truth.empty() ? Eigen::Vector3d::Zero() : study.truth.front().pose.p;
  Json json{{"folder", study.folder},
            {"single_run", study.single_run},
            {"summary", Json::parse(study.summary)},
            {"bands", bands_json(runs_that_count(study))},
            {"origin", {origin.x(), origin.y(), origin.z()}}};
  json["seconds"] = length == 0 ? float_column({}) : float_column(longest->seconds);
  json["filters"] = Json::array();
  for (const StudyCurves& curves : study.filters) {
    json["filters"].push_back(curves_json(curves, length, origin));
  }
  json["trials"] = trials_json(study.trials);
  if (study.truth.empty()) return json;
  json["truth"] = points(thinned(study.truth), 0, origin, position);
  json["landmarks"] = points(study.landmarks, 0, origin, place);
  return json;
}

}  // namespace

std::string study_page(const std::vector<Study>& studies) {
  if (studies.empty()) {
    throw UsageError(
        "a report needs at least one study: name the folder that `chasles compare` or "
        "`chasles montecarlo` wrote");
  }
  Json data{{"studies", Json::array()}};
  for (const Study& study : studies) data["studies"].push_back(study_json(study));
  return with_data(study_template, data);
}

}  // namespace chasles
