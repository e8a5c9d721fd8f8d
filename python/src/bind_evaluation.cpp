#include <optional>

#include <pybind11/stl.h>

#include <chasles/eval/evaluation.hpp>
#include <chasles/sim/inertial_settings.hpp>
#include <chasles/sim/street.hpp>

#include "arrays.hpp"
#include "inertial_settings_io.hpp"
#include "module.hpp"
#include "settings_io.hpp"
#include "velocity_settings_io.hpp"

namespace chasles::python {
namespace {

py::dict evaluate_columns(
    const py::array& times, const Rows& positions, const Rows& quaternions,
    const py::array& truth_times, const Rows& truth_positions, const Rows& truth_quaternions,
    const std::optional<py::array_t<double, py::array::c_style | py::array::forcecast>>&
        pose_covariances,
    const std::string& chart, bool level) {
  const Trajectory estimate = trajectory_of(times, positions, quaternions);
  const Trajectory truth = trajectory_of(truth_times, truth_positions, truth_quaternions);
  std::vector<Matrix6d> covariances;
  if (pose_covariances) {
    const auto& given = *pose_covariances;
    if (given.ndim() != 3 || given.shape(0) != static_cast<py::ssize_t>(estimate.size()) ||
        given.shape(1) != 6 || given.shape(2) != 6) {
      throw py::value_error("pose_covariance: expected (N, 6, 6), one for each pose");
    }
    for (py::ssize_t i = 0; i < given.shape(0); ++i) {
      covariances.push_back(
          Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(given.data(i, 0, 0)));
    }
  }
  Evaluation evaluation;
  {
    const py::gil_scoped_release released;
    EvaluationOptions options;
    options.pose_error = pose_error_of(chart);
    options.level = level;
    evaluation = evaluate(estimate, truth, covariances, options);
  }
  py::dict result;
  for (const auto& [name, value] : figures(evaluation)) result[py::str(name)] = value;
  return result;
}

// Defaults, units and meanings.
py::dict settings_of(const std::string& kind) {
  InertialRunSettings inertial;
  VelocityRunSettings velocity;
  app::SettingList list;
  const auto add = [&](app::SettingList more) {
    for (app::Setting& one : more) list.push_back(std::move(one));
  };
  if (kind == "imu") {
    add(app::setting_list(inertial.filter));
    add(app::list_of(inertial.start, "start."));
    add(app::list_of(inertial.frontend, "frontend."));
    add(app::setting_list(inertial.batch));
  } else if (kind == "velocity") {
    add(app::setting_list(velocity.filter));
    add(app::list_of(velocity.batch, "batch."));
  } else {
    throw py::value_error("settings: found '" + kind + "', expected 'imu' or 'velocity'");
  }
  py::dict result;
  for (const app::Setting& one : list) {
    py::dict entry;
    entry["default"] = app::value_text(one);
    entry["unit"] = one.unit;
    entry["meaning"] = one.meaning;
    result[py::str(one.name)] = entry;
  }
  return result;
}

}  // namespace

void bind_evaluation(py::module_& m) {
  m.def("evaluate", &evaluate_columns, py::arg("time"), py::arg("position"), py::arg("quaternion"),
        py::arg("truth_time"), py::arg("truth_position"), py::arg("truth_quaternion"),
        py::arg("pose_covariance") = std::nullopt, py::arg("chart") = "standard",
        py::arg("level") = false);
  m.def("settings", &settings_of, py::arg("kind"));
}

}  // namespace chasles::python
