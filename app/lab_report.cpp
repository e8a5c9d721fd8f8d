#include "lab_report.hpp"

#include <cmath>
#include <initializer_list>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/constants.hpp>
#include <chasles/eval/table.hpp>

#include "filter_options.hpp"

namespace chasles::app {
namespace {

using Json = nlohmann::ordered_json;

std::size_t counted(const FilterSummary& summary) { return summary.runs - summary.diverged; }

// 95 % band of the mean over this number of runs; NaN without runs.
Band band_of(int dof, std::size_t runs) {
  const double nan = std::nan("");
  return runs == 0 ? Band{.low = nan, .high = nan} : chi2_band(dof, runs);
}

std::string csv_number(double value) {
  return std::isfinite(value) ? fmt::format("{}", value) : "nan";
}

std::string band_cell(const FilterSummary& s) {
  return counted(s) == 0 ? "-" : fmt::format("{:.3f} .. {:.3f}", s.band.low, s.band.high);
}

std::string percent_cell(double fraction) {
  return std::isfinite(fraction) ? fmt::format("{:.0f} %", 100 * fraction) : "-";
}

void append(std::vector<std::string>& cells, std::initializer_list<std::string> more) {
  cells.insert(cells.end(), more);
}

Table nees_table(std::span<const FilterSummary> summaries, bool several) {
  Table table;
  append(table.header, {"filter", "position", "attitude", "pose/dof", "state/dof",
                        "cov. too small by", "NIS/dof", "innov. corr."});
  if (several) {
    append(table.header, {"median pose/dof", "95 % band", "seconds inside", "runs", "diverged"});
  }
  for (const FilterSummary& s : summaries) {
    auto& row = table.rows.emplace_back();
    append(row,
           {s.filter, cell(s.mean.nees_position, 2), cell(s.mean.nees_attitude, 2),
            cell(s.nees_per_dof, 3), cell(s.mean.nees_state / 15, 3), cell(s.covariance_factor, 2),
            cell(s.mean.nis_per_dof, 3), cell(s.mean.innovation_correlation, 3)});
    if (several) {
      append(row, {cell(s.median.nees_pose / 6, 3), band_cell(s), percent_cell(s.seconds_inside),
                   fmt::format("{}", s.runs), fmt::format("{}", s.diverged)});
    }
  }
  return table;
}

Table error_table(std::span<const FilterSummary> summaries, std::span<const double> milliseconds) {
  const bool several = milliseconds.empty();
  Table table;
  append(table.header, {"filter", "position [m]", "attitude [deg]", "ATE, yaw aligned [m]"});
  if (several) append(table.header, {"median [m]", "median [deg]"});
  append(table.header, {"landmarks"});
  if (!several) append(table.header, {"CPU [ms/frame]"});
  for (std::size_t i = 0; i < summaries.size(); ++i) {
    const FilterSummary& s = summaries[i];
    auto& row = table.rows.emplace_back();
    append(row, {s.filter, cell(s.mean.position_error, 4),
                 cell(s.mean.attitude_error * kDegrees, 3), cell(s.mean.ate_posyaw, 4)});
    if (several) {
      append(row, {cell(s.median.position_error, 4), cell(s.median.attitude_error * kDegrees, 3)});
    }
    append(row, {cell(s.mean.landmarks, 0)});
    if (!several) append(row, {cell(milliseconds[i], 3)});
  }
  return table;
}

}  // namespace

Json number_json(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json figures_json(const FilterVariant& filter, const FilterSummary& s) {
  return {{"filter", s.filter},
          {"chart", filter.settings.chart},
          {"estimator", name_of(filter.estimator)},
          {"runs", s.runs},
          {"diverged", s.diverged},
          {"position_error_m", number_json(s.mean.position_error)},
          {"position_rms_m", number_json(s.mean.position_rms)},
          {"ate_m", number_json(s.mean.ate)},
          {"ate_posyaw_m", number_json(s.mean.ate_posyaw)},
          {"attitude_posyaw_deg", number_json(s.mean.attitude_posyaw * kDegrees)},
          {"attitude_error_deg", number_json(s.mean.attitude_error * kDegrees)},
          {"nees_position", number_json(s.mean.nees_position)},
          {"nees_attitude", number_json(s.mean.nees_attitude)},
          {"nees_pose", number_json(s.mean.nees_pose)},
          {"nees_pose_per_dof", number_json(s.nees_per_dof)},
          {"nees_state", number_json(s.mean.nees_state)},
          {"covariance_too_small_by", number_json(s.covariance_factor)},
          {"nis_per_dof", number_json(s.mean.nis_per_dof)},
          {"innovation_correlation", number_json(s.mean.innovation_correlation)},
          {"landmarks", number_json(s.mean.landmarks)},
          {"median",
           {{"position_error_m", number_json(s.median.position_error)},
            {"attitude_error_deg", number_json(s.median.attitude_error * kDegrees)},
            {"nees_position", number_json(s.median.nees_position)},
            {"nees_attitude", number_json(s.median.nees_attitude)},
            {"nees_pose", number_json(s.median.nees_pose)},
            {"nees_state", number_json(s.median.nees_state)}}},
          {"band", counted(s) == 0 ? Json() : Json{s.band.low, s.band.high}},
          {"seconds_inside_band", number_json(s.seconds_inside)}};
}

std::string tables(std::span<const FilterSummary> summaries, std::span<const double> milliseconds,
                   TableStyle style) {
  const bool markdown = style == TableStyle::kMarkdown;
  const auto text = [&](const Table& table) {
    return markdown ? to_markdown(table) : to_text(table);
  };
  return fmt::format(
      "{0}Average NEES (consistent: 3 for position and attitude, 1 per degree of freedom)\n{1}{2}\n"
      "{0}Average error\n{1}{3}",
      markdown ? "### " : "", markdown ? "\n" : "",
      text(nees_table(summaries, milliseconds.empty())),
      text(error_table(summaries, milliseconds)));
}

std::string curves_csv(std::span<const FilterSummary> summaries) {
  std::string text =
      "filter,second,position_error_m,attitude_error_deg,nees_position,nees_attitude,nees_pose,"
      "nees_state,band_3_low,band_3_high,band_6_low,band_6_high\n";
  for (const FilterSummary& s : summaries) {
    const Band three = band_of(3, counted(s)), six = band_of(6, counted(s));
    for (std::size_t second = 0; second < s.seconds.size(); ++second) {
      const TrialRecord::Second& mean = s.seconds[second];
      text += fmt::format("{},{}", s.filter, second);
      for (const double value : {mean.position_error, mean.attitude_error * kDegrees,
                                 mean.nees_position, mean.nees_attitude, mean.nees_pose,
                                 mean.nees_state, three.low, three.high, six.low, six.high}) {
        text += ',' + csv_number(value);
      }
      text += '\n';
    }
  }
  return text;
}

}  // namespace chasles::app
