#include <fmt/format.h>

#include <chasles/eval/truth_errors_table.hpp>

namespace chasles {
namespace {

const char* yes_or_no(bool yes) { return yes ? "yes" : "no"; }

void append_axes(Table& table, const char* what, TruthErrorKind kind, Eigen::Index first,
                 const TruthErrors& errors) {
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    table.rows.push_back({fmt::format("{} {}, deg", what, "xyz"[axis]),
                          cell(kDegrees * errors.value[first + axis], 2),
                          cell(kDegrees * errors.sigma(first + axis), 2),
                          axis == 0 ? yes_or_no(errors.significant(kind)) : ""});
  }
}

std::optional<double> of_rigid(const Evaluation& evaluation, Statistics AbsoluteError::*figure) {
  const AbsoluteError* error = find(evaluation, Alignment::kRigid);
  return error ? std::optional((error->*figure).rmse) : std::nullopt;
}

}  // namespace

Table truth_errors_table(const TruthErrors& errors) {
  Table table{.header = {"constant of the truth", "value", "sigma", "significant"}, .rows = {}};
  table.rows.push_back({"time of the positions, ms", cell(1e3 * errors.value[0], 1),
                        cell(1e3 * errors.sigma(0), 1),
                        yes_or_no(errors.significant(TruthErrorKind::kPositionTime))});
  append_axes(table, "body", TruthErrorKind::kBodyRotation, 1, errors);
  append_axes(table, "world", TruthErrorKind::kWorldRotation, 4, errors);
  table.rows.push_back({"heading of the first pose, deg", cell(kDegrees * errors.first_heading, 2),
                        cell(kDegrees * errors.first_heading_sigma, 2),
                        yes_or_no(errors.first_heading_significant())});
  return table;
}

Table without_truth_errors_table(const Evaluation& as_it_is, const TruthErrors& errors) {
  Table table{.header = {"figure", "as it is", "without errors of the truth", "dof fitted %"},
              .rows = {}};
  const auto append = [&](const char* what, ConsistencySummary Nees::*summary, std::size_t i) {
    const auto before =
        as_it_is.nees ? std::optional(((*as_it_is.nees).*summary).mean) : std::nullopt;
    table.rows.push_back({what, cell(before, 2), cell((errors.nees.*summary).mean, 2),
                          cell(100 * errors.fitted_share.at(i), 0)});
  };
  append("NEES position (3)", &Nees::position_summary, 0);
  append("NEES attitude (3)", &Nees::attitude_summary, 1);
  append("NEES pose (6)", &Nees::pose_summary, 2);
  table.rows.push_back({"ATE m, SE(3)", cell(of_rigid(as_it_is, &AbsoluteError::position_m), 4),
                        cell(errors.rigid.position_m.rmse, 4), ""});
  table.rows.push_back({"attitude deg, SE(3)",
                        cell(of_rigid(as_it_is, &AbsoluteError::attitude_deg), 3),
                        cell(errors.rigid.attitude_deg.rmse, 3), ""});
  return table;
}

}  // namespace chasles
