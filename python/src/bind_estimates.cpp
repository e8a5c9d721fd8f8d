#include <optional>

#include <fmt/format.h>
#include <pybind11/stl.h>

#include <chasles/estimate/estimate.hpp>
#include <chasles/slam/state_predictor.hpp>

#include "arrays.hpp"
#include "module.hpp"

namespace chasles::python {
namespace {

std::optional<Eigen::Vector3d> bias(const Estimate& e, Eigen::Index first) {
  if (!e.v_world || e.additive.size() < 6) return std::nullopt;
  return Eigen::Vector3d(e.additive.segment<3>(first));
}

std::string text_of(const Estimate& e) {
  const Eigen::Vector3d& p = e.world_T_imu.p;
  const Eigen::Vector3d sigma = e.covariance.diagonal().segment<3>(3).cwiseMax(0).cwiseSqrt();
  return fmt::format(
      "<chasles.Estimate t={} ns p=({:.3f}, {:.3f}, {:.3f}) m sigma=({:.3f}, {:.3f}, "
      "{:.3f}) m {}>",
      e.time.count(), p.x(), p.y(), p.z(), sigma.x(), sigma.y(), sigma.z(), name(e.health));
}

}  // namespace

void bind_estimates(py::module_& m) {
  py::class_<Estimate>(m, "Estimate", "The estimate of a frame.")
      .def_property_readonly(
          "time", [](const Estimate& e) { return e.time.count(); }, "On the IMU's clock [ns].")
      .def_property_readonly(
          "seconds", [](const Estimate& e) { return to_seconds(e.time); },
          "On the IMU's clock [s].")
      .def_property_readonly(
          "world_T_imu", [](const Estimate& e) { return matrix(e.world_T_imu); },
          "(4, 4) [m]: maps IMU coordinates to the world's; z points up.")
      .def_property_readonly(
          "position", [](const Estimate& e) { return Eigen::Vector3d(e.world_T_imu.p); },
          "(3,) world [m].")
      .def_property_readonly(
          "quaternion", [](const Estimate& e) { return quaternion_xyzw(e.world_T_imu.R); },
          "(4,) x y z w of world_T_imu.")
      .def_property_readonly(
          "velocity", [](const Estimate& e) { return e.v_world; }, "(3,) world [m/s].")
      .def_property_readonly(
          "accelerometer_bias", [](const Estimate& e) { return bias(e, 0); }, "(3,) [m/s^2].")
      .def_property_readonly(
          "gyroscope_bias", [](const Estimate& e) { return bias(e, 3); }, "(3,) [rad/s].")
      .def_property_readonly(
          "covariance", [](const Estimate& e) { return Eigen::MatrixXd(e.covariance); },
          "(n, n) of [theta; dp; dv; biases]: R = Exp(theta) R_hat, p = p_hat + dp, world axes.")
      .def_property_readonly(
          "pose_covariance", [](const Estimate& e) { return Eigen::MatrixXd(e.pose_covariance()); },
          "(6, 6) of [theta; dp] [rad, m].")
      .def_property_readonly(
          "map_T_imu",
          [](const Estimate& e) -> std::optional<Eigen::Matrix4d> {
            if (!e.in_map) return std::nullopt;
            return matrix(e.in_map->map_T_imu);
          },
          "(4, 4) in the frame of the map, or None.")
      .def_property_readonly(
          "world_T_map",
          [](const Estimate& e) -> std::optional<Eigen::Matrix4d> {
            if (!e.in_map) return std::nullopt;
            return matrix(e.in_map->world_T_map);
          },
          "(4, 4) frame of the map in the world (REP 105: odom_T_map), or None.")
      .def_property_readonly(
          "health", [](const Estimate& e) { return std::string(name(e.health)); },
          "'ok', 'degraded' or 'lost'.")
      .def_readonly("nis", &Estimate::nis, "Normalised innovation squared of the update.")
      .def_readonly("nis_dof", &Estimate::nis_dof, "Its degrees of freedom; 0: no update.")
      .def_readonly("observations", &Estimate::observations, "Of the frame.")
      .def_readonly("used", &Estimate::used, "Observations that updated the state.")
      .def_readonly("rejected", &Estimate::rejected, "Observations that the gate rejected.")
      .def_readonly("landmarks", &Estimate::landmarks, "Of the whole map.")
      .def("__repr__", &text_of);

  py::class_<PredictedState>(m, "PredictedState", "The motion after the last estimate, by the IMU.")
      .def_property_readonly(
          "time", [](const PredictedState& s) { return s.time.count(); },
          "On the IMU's clock [ns].")
      .def_property_readonly(
          "seconds_since_estimate",
          [](const PredictedState& s) { return to_seconds(s.since_estimate); },
          "Time since the last estimate [s].")
      .def_property_readonly(
          "world_T_imu", [](const PredictedState& s) { return matrix(s.state.world_T_imu); },
          "(4, 4) [m].")
      .def_property_readonly(
          "position",
          [](const PredictedState& s) { return Eigen::Vector3d(s.state.world_T_imu.p); },
          "(3,) world [m].")
      .def_property_readonly(
          "quaternion",
          [](const PredictedState& s) { return quaternion_xyzw(s.state.world_T_imu.R); },
          "(4,) x y z w of world_T_imu.")
      .def_property_readonly(
          "velocity", [](const PredictedState& s) { return s.state.v_world; }, "(3,) world [m/s].")
      .def_property_readonly("angular_rate", copy_of(&PredictedState::angular_rate_imu),
                             "(3,) IMU axes, without bias [rad/s].")
      .def_property_readonly(
          "covariance", [](const PredictedState& s) { return Eigen::MatrixXd(s.covariance); },
          "(15, 15), as Estimate.covariance.")
      .def("__repr__", [](const PredictedState& s) {
        const Eigen::Vector3d& p = s.state.world_T_imu.p;
        return fmt::format(
            "<chasles.PredictedState t={} ns p=({:.3f}, {:.3f}, {:.3f}) m, {:.3f} s after the "
            "estimate>",
            s.time.count(), p.x(), p.y(), p.z(), to_seconds(s.since_estimate));
      });
}

}  // namespace chasles::python
