#include <memory>
#include <optional>
#include <string>
#include <utility>

#include <Eigen/LU>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <chasles/base/error.hpp>
#include <chasles/filter/charts/registered_charts.hpp>
#include <chasles/filter/depth_rule.hpp>

#include "arrays.hpp"
#include "module.hpp"
#include "turns.hpp"

// Error charts and depth rules that are written in Python. The filter calls them without the GIL,
// so each call takes it. What is registered stays for the life of the process.
namespace chasles::python {
namespace {

using Eigen::Index;
using Vector9d = Eigen::Matrix<double, 9, 1>;
using Matrix9d = Eigen::Matrix<double, 9, 9>;

// What a chart moves: additive states and landmarks in inverse depth are the same in all charts.
struct ChartState {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d p = Eigen::Vector3d::Zero(), v = Eigen::Vector3d::Zero();
  Rows points = Rows(0, 3);
};

// A chart or a rule, with what begins its messages. Never freed, as filters may outlive the
// interpreter's other objects.
struct Named {
  std::string name;
  py::object object;
};
const Named& kept(const char* kind, const std::string& name, py::object object) {
  return *new Named{.name = fmt::format("{} '{}'", kind, name), .object = std::move(object)};
}

// Calls a method of a chart.
template <typename Result, typename... Arguments>
Result call(const Named& chart, const char* method, const char* expected,
            const Arguments&... arguments) {
  return as<Result>(chart.object.attr(method)(arguments...),
                    fmt::format("{}: {} returned", chart.name, method), expected);
}

ChartState chart_state(const State& x) {
  ChartState s{
      .R = x.world_T_imu.R, .p = x.world_T_imu.p, .v = x.v_world.value_or(Eigen::Vector3d::Zero())};
  const auto cartesian =
      std::ranges::count_if(x.landmarks, [](const Landmark& l) { return !l.anchor; });
  s.points.resize(cartesian, 3);
  Index i = 0;
  for (const Landmark& landmark : x.landmarks) {
    if (!landmark.anchor) s.points.row(i++) = landmark.p_world;
  }
  return s;
}

// The errors that a chart defines: (9,) of [theta, dp, dv], and (N, 3) of the points.
std::pair<Vector9d, Rows> chart_errors(const State& x, const ErrorRef& xi) {
  Vector9d motion = Vector9d::Zero();
  motion.head(x.motion_size()) = xi.head(x.motion_size());
  Rows points(static_cast<Index>(x.landmarks.size()), 3);
  Index i = 0;
  for (const Landmark& landmark : x.landmarks) {
    if (!landmark.anchor) points.row(i++) = xi.segment<3>(landmark.row);
  }
  points.conservativeResize(i, 3);
  return {motion, points};
}

void check_points(const Named& chart, const char* method, const Rows& points, Index expected) {
  if (points.rows() == expected && (expected == 0 || points.cols() == 3)) return;
  throw py::value_error(fmt::format("{}: {} returned points {} x {}, expected {} x 3", chart.name,
                                    method, points.rows(), points.cols(), expected));
}

void retract_in_python(const Named& chart, State& x, const ErrorRef& xi) {
  {
    const PythonCall held;
    const auto [motion, points] = chart_errors(x, xi);
    const auto y =
        call<ChartState>(chart, "retract", "a ChartState", chart_state(x), motion, points);
    check_points(chart, "retract", y.points, points.rows());
    x.world_T_imu = {y.R, y.p};
    if (x.v_world) x.v_world = y.v;
    Index i = 0;
    for (Landmark& landmark : x.landmarks) {
      if (!landmark.anchor) landmark.p_world = y.points.row(i++);
    }
  }
  x.additive += xi.segment(x.additive_row(), x.additive.size());
  for (Landmark& landmark : x.landmarks) {
    if (landmark.anchor) landmark.inverse_depth += xi.segment<3>(landmark.row);
  }
}

Eigen::VectorXd local_in_python(const Named& chart, const State& x, const State& y) {
  Eigen::VectorXd xi = Eigen::VectorXd::Zero(x.size());
  xi.segment(x.additive_row(), x.additive.size()) = y.additive - x.additive;
  const PythonCall held;
  const auto [motion, points] = call<std::pair<Vector9d, Rows>>(
      chart, "local", "a pair of arrays ((9,), (N, 3))", chart_state(x), chart_state(y));
  xi.head(x.motion_size()) = motion.head(x.motion_size());
  check_points(chart, "local", points,
               std::ranges::count_if(x.landmarks, [](const Landmark& l) { return !l.anchor; }));
  Index i = 0;
  for (std::size_t k = 0; k < x.landmarks.size(); ++k) {
    const Landmark& landmark = x.landmarks[k];
    xi.segment<3>(landmark.row) = landmark.anchor
                                      ? y.landmarks[k].inverse_depth - landmark.inverse_depth
                                      : Eigen::Vector3d(points.row(i++));
  }
  return xi;
}

void register_chart(const std::string& name, py::object object) {
  const Named& chart = kept("error chart", name, std::move(object));
  CustomChart made{
      .name = name,
      .summary = "written in Python",
      .retract = [&chart](State& x, const ErrorRef& xi) { retract_in_python(chart, x, xi); },
      .local = [&chart](const State& x, const State& y) { return local_in_python(chart, x, y); },
      .motion_block =
          [&chart](const State& x) {
            const PythonCall held;
            return call<Matrix9d>(chart, "motion_block", "an array (9, 9)", chart_state(x));
          }};
  const py::object block = py::getattr(chart.object, "landmark_block", py::none());
  if (!block.is_none()) {
    made.landmark_block = [&chart](const Eigen::Vector3d& p) {
      const PythonCall held;
      return call<Eigen::Matrix3d>(chart, "landmark_block", "an array (3, 3)", p);
    };
  }
  register_error_chart(std::move(made));
}

// A point that is seen for the first time, as Python sees it.
struct FirstSight {
  Eigen::Vector2d pixel;
  int camera = 0;
  bool inverse = false;
  SE3 world_T_camera;
  Eigen::Vector3d ray;  ///< wide_ray
  Rows points;          ///< landmarks of the state, world [m]
};

FirstSight first_sight(const FirstObservation& o) {
  const State& x = o.state;
  const auto camera = static_cast<std::size_t>(o.camera_index);
  const SE3 imu_T_camera =
      x.imu_T_camera.empty() ? o.camera.cam_T_imu.inverse() : x.imu_T_camera[camera];
  FirstSight sight{.pixel = o.pixel,
                   .camera = o.camera_index,
                   .inverse = o.inverse,
                   .world_T_camera = x.world_T_imu * imu_T_camera,
                   .ray = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN()),
                   .points = Rows(static_cast<Index>(x.landmarks.size()), 3)};
  if (const auto ray = wide_ray(o.camera, o.pixel)) sight.ray = ray->ray;
  Index i = 0;
  for (const Landmark& landmark : x.landmarks) {
    if (landmark.has_place()) sight.points.row(i++) = x.p_world(landmark);
  }
  sight.points.conservativeResize(i, 3);
  return sight;
}

void register_rule(const std::string& name, py::object object) {
  const Named& rule = kept("depth rule", name, std::move(object));
  register_depth_rule(name, [&rule](const FirstObservation& o) -> std::optional<AssumedDepth> {
    const PythonCall held;
    const py::object depth = rule.object(first_sight(o));
    if (depth.is_none()) return std::nullopt;
    const auto [mean, sigma] =
        as<std::pair<double, double>>(depth, rule.name + " returned", "(mean, sigma), or None");
    return AssumedDepth{.mean = mean, .sigma = sigma};
  });
}

}  // namespace

void bind_charts(py::module_& m) {
  py::class_<ChartState>(m, "ChartState", "The parts of a state that an error chart moves.")
      .def(py::init([](const Eigen::Matrix3d& R, const Eigen::Vector3d& p, const Eigen::Vector3d& v,
                       const Rows& points) {
             return ChartState{.R = R, .p = p, .v = v, .points = points};
           }),
           py::arg("R"), py::arg("p"), py::arg("v"), py::arg("points"))
      .def_property("R", copy_of(&ChartState::R), assign(&ChartState::R),
                    "(3, 3): attitude, world_R_imu.")
      .def_property("p", copy_of(&ChartState::p), assign(&ChartState::p), "(3,) world [m].")
      .def_property("v", copy_of(&ChartState::v), assign(&ChartState::v),
                    "(3,) world [m/s]; zero for a past pose.")
      .def_property("points", copy_of(&ChartState::points), assign(&ChartState::points),
                    "(N, 3): Cartesian landmarks, world [m].")
      .def("__repr__", [](const ChartState& x) {
        return fmt::format("<chasles.ChartState p=({:.3f}, {:.3f}, {:.3f}) m, {} points>", x.p.x(),
                           x.p.y(), x.p.z(), x.points.rows());
      });
  py::class_<FirstSight>(m, "FirstSight", "A point that is seen for the first time.")
      .def_property_readonly("pixel", copy_of(&FirstSight::pixel), "(2,) [px].")
      .def_readonly("camera", &FirstSight::camera, "Index of the camera.")
      .def_readonly("inverse", &FirstSight::inverse,
                    "Whether the landmark has an inverse depth [1/m] or a depth [m].")
      .def_property_readonly(
          "world_T_camera", [](const FirstSight& s) { return matrix(s.world_T_camera); },
          "(4, 4) [m].")
      .def_property_readonly("ray", copy_of(&FirstSight::ray),
                             "(3,): (x/z, y/z, 1) in the camera's axes.")
      .def_property_readonly("points", copy_of(&FirstSight::points),
                             "(N, 3): landmarks of the state, world [m].")
      .def("__repr__", [](const FirstSight& s) {
        return fmt::format("<chasles.FirstSight at ({:.1f}, {:.1f}) px of camera {}>", s.pixel.x(),
                           s.pixel.y(), s.camera);
      });
  m.def("register_chart", &register_chart, py::arg("name"), py::arg("chart"));
  m.def("register_depth_rule", &register_rule, py::arg("name"), py::arg("rule"));
}

}  // namespace chasles::python
