#include <optional>
#include <string>
#include <type_traits>
#include <variant>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <pybind11/stl.h>

#include <chasles/base/error.hpp>
#include <chasles/eval/evaluation.hpp>
#include <chasles/filter/charts/error_chart_names.hpp>
#include <chasles/sim/inertial_settings.hpp>
#include <chasles/sim/street.hpp>

#include "arrays.hpp"
#include "inertial_settings_io.hpp"
#include "interpreter_exit.hpp"
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
  const Trajectory estimate = trajectory_of("estimate", times, positions, quaternions);
  const Trajectory truth = trajectory_of("truth", truth_times, truth_positions, truth_quaternions);
  std::vector<Matrix6d> covariances;
  if (pose_covariances) {
    const auto& given = *pose_covariances;
    if (given.ndim() != 3 || given.shape(0) != static_cast<py::ssize_t>(estimate.size()) ||
        given.shape(1) != 6 || given.shape(2) != 6) {
      throw InputError(
          fmt::format("estimate: pose_covariance: found {}, expected (N, 6, 6), one for each pose",
                      description(given)));
    }
    for (py::ssize_t i = 0; i < given.shape(0); ++i) {
      covariances.push_back(
          Eigen::Map<const Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(given.data(i, 0, 0)));
    }
  }
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

// The type of a setting, as Python's annotations have it.
std::string type_of(const app::Setting& setting) {
  const auto text = [&](const auto& value) -> std::string {
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (std::is_same_v<Value, app::Setting::ChoiceRef>) {
      return fmt::format("Literal['{}']", fmt::join(setting.limits.names, "', '"));
    } else if constexpr (std::is_same_v<Value, std::optional<double>*>) {
      return "Union[float, Literal['auto'], None]";
    } else if constexpr (std::is_same_v<Value, double*>) {
      return "float";
    } else if constexpr (std::is_same_v<Value, bool*>) {
      return "bool";
    } else if constexpr (std::is_same_v<Value, std::string*>) {
      return "str";
    } else {
      return "int";
    }
  };
  return std::visit(text, setting.value);
}

// Defaults, units, meanings and types.
py::dict settings_of(const std::string& kind) {
  InertialRunSettings inertial;
  app::VelocityCommandSettings velocity;
  InertialSettings scene;
  StreetSettings street;
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
    add(app::setting_list(velocity.reader));
  } else if (kind == "scene") {
    add(app::list_of(scene));
  } else if (kind == "street") {
    add(app::list_of(street));
  } else {
    throw py::value_error("settings: found '" + kind +
                          "', expected 'imu', 'velocity', 'scene' or 'street'");
  }
  py::dict result;
  for (const app::Setting& one : list) {
    py::dict entry;
    entry["default"] = app::value_text(one);
    entry["unit"] = one.unit;
    entry["meaning"] = one.meaning;
    entry["type"] = type_of(one);
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
  m.def("chart_names", [] {
    std::vector<std::string> names;
    for (const std::string_view name : error_chart_names()) names.emplace_back(name);
    return names;
  });
  m.def("settings", &settings_of, py::arg("kind"));
}

}  // namespace chasles::python
