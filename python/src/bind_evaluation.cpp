#include <optional>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <pybind11/stl.h>

#include <chasles/base/error.hpp>
#include <chasles/eval/evaluation.hpp>
#include <chasles/filter/charts/error_chart_names.hpp>
#include <chasles/session/inertial_settings_io.hpp>
#include <chasles/session/settings_io.hpp>
#include <chasles/session/truth_errors_json.hpp>
#include <chasles/session/velocity_settings_io.hpp>

#include "arrays.hpp"
#include "interpreter_exit.hpp"
#include "module.hpp"
#include "setting_table.hpp"

namespace chasles::python {
namespace {

using PoseCovariances =
    std::optional<py::array_t<double, py::array::c_style | py::array::forcecast>>;

std::vector<Matrix6d> covariances_of(const PoseCovariances& pose_covariances, std::size_t poses) {
  std::vector<Matrix6d> covariances;
  if (!pose_covariances) return covariances;
  const auto& given = *pose_covariances;
  if (given.ndim() != 3 || given.shape(0) != static_cast<py::ssize_t>(poses) ||
      given.shape(1) != 6 || given.shape(2) != 6) {
    throw InputError(
        fmt::format("estimate: pose_covariance: found {}, expected (N, 6, 6), one for each pose",
                    description(given)));
  }
  for (py::ssize_t i = 0; i < given.shape(0); ++i) {
    covariances.push_back(
        Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(given.data(i, 0, 0)));
  }
  return covariances;
}

// As JSON.
std::string truth_errors_of_columns(const py::array& times, const Rows& positions,
                                    const Rows& quaternions, const py::array& truth_times,
                                    const Rows& truth_positions, const Rows& truth_quaternions,
                                    const PoseCovariances& pose_covariances,
                                    const std::string& chart, bool level) {
  if (!pose_covariances || quaternions.size() == 0) {
    throw UsageError(
        "evaluate: truth_errors: the estimate has no covariances or no attitudes, expected the "
        "columns quaternion and pose_covariance, as Run.states has them");
  }
  if (truth_quaternions.size() == 0) {
    throw UsageError(
        "evaluate: truth_errors: the truth has positions alone, expected poses with attitudes");
  }
  const Trajectory estimate = trajectory_of("estimate", times, positions, quaternions);
  const Trajectory truth = trajectory_of("truth", truth_times, truth_positions, truth_quaternions);
  const std::vector<Matrix6d> covariances = covariances_of(pose_covariances, estimate.size());
  const Released released;
  return truth_errors_json(
             estimate_truth_errors(
                 estimate, truth, covariances,
                 {.pairing = {}, .pose_error = pose_error_of(chart), .level = level, .priors = {}}))
      .dump();
}

py::dict evaluate_columns(const py::array& times, const Rows& positions, const Rows& quaternions,
                          const py::array& truth_times, const Rows& truth_positions,
                          const Rows& truth_quaternions, const PoseCovariances& pose_covariances,
                          const std::string& chart, bool level) {
  const Trajectory estimate = trajectory_of("estimate", times, positions, quaternions);
  const Trajectory truth = trajectory_of("truth", truth_times, truth_positions, truth_quaternions);
  const std::vector<Matrix6d> covariances = covariances_of(pose_covariances, estimate.size());
  Evaluation evaluation;
  {
    const Released released;
    EvaluationOptions options;
    options.pose_error = pose_error_of(chart);
    options.level = level;
    options.attitudes = quaternions.size() > 0 && truth_quaternions.size() > 0;
    evaluation = evaluate(estimate, truth, covariances, options);
  }
  py::dict result;
  for (const auto& [name, value] : figures(evaluation)) result[py::str(name)] = value;
  return result;
}

// Of runs.
py::dict settings_of(const std::string& kind) {
  InertialRunSettings inertial;
  VelocityCommandSettings velocity;
  SettingList list;
  const auto add = [&](SettingList more) {
    for (Setting& one : more) list.push_back(std::move(one));
  };
  if (kind == "imu") {
    add(setting_list(inertial.filter));
    add(list_of(inertial.start, "start."));
    add(list_of(inertial.frontend, "frontend."));
    add(setting_list(inertial.batch));
  } else if (kind == "velocity") {
    add(setting_list(velocity.filter));
    add(list_of(velocity.batch, "batch."));
    add(setting_list(velocity.reader));
  } else {
    throw py::value_error("settings: found '" + kind +
                          "', expected 'imu', 'velocity', 'scene' or 'street'");
  }
  return table_of(list);
}

}  // namespace

void bind_evaluation(py::module_& m) {
  m.def("evaluate", &evaluate_columns, py::arg("time"), py::arg("position"), py::arg("quaternion"),
        py::arg("truth_time"), py::arg("truth_position"), py::arg("truth_quaternion"),
        py::arg("pose_covariance") = std::nullopt, py::arg("chart") = "standard",
        py::arg("level") = false);
  m.def("truth_errors", &truth_errors_of_columns, py::arg("time"), py::arg("position"),
        py::arg("quaternion"), py::arg("truth_time"), py::arg("truth_position"),
        py::arg("truth_quaternion"), py::arg("pose_covariance"), py::arg("chart"),
        py::arg("level"));
  m.def("chart_names", [] {
    std::vector<std::string> names;
    for (const std::string_view name : error_chart_names()) names.emplace_back(name);
    return names;
  });
  m.def("settings", &settings_of, py::arg("kind"));
}

}  // namespace chasles::python
