#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <chasles/base/constants.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/session/calibration_report.hpp>
#include <chasles/slam/inertial_calibration.hpp>

namespace chasles {
namespace {

using Json = nlohmann::ordered_json;

// Rotation from the recording's calibration to the estimate, IMU axes.
Eigen::Vector3d turned(const SE3& imu_T_camera, const Camera& camera) {
  return so3::log(imu_T_camera.R * camera.cam_T_imu.R);
}

Eigen::Vector3d sigmas(const Calibration& calibration, Eigen::Index row) {
  return calibration.covariance.diagonal().segment<3>(row).cwiseMax(0).cwiseSqrt();
}

Json list(const Eigen::Vector3d& v) { return Json::array({v.x(), v.y(), v.z()}); }

Json matrix(const SE3& T) {
  Json rows = Json::array();
  for (int i = 0; i < 3; ++i) {
    rows.push_back(Json::array({T.R(i, 0), T.R(i, 1), T.R(i, 2), T.p[i]}));
  }
  rows.push_back(Json::array({0, 0, 0, 1}));
  return rows;
}

Json camera_json(const Calibration& calibration, std::size_t i, const Camera& camera) {
  const SE3& imu_T_camera = calibration.imu_T_camera[i];
  const auto row = 6 * static_cast<Eigen::Index>(i);
  const Eigen::Vector3d moved = imu_T_camera.p - camera.cam_T_imu.inverse().p;
  return {{"imu_T_cam", matrix(imu_T_camera)},
          {"rotation_sigma_deg", list(kDegrees * sigmas(calibration, row))},
          {"position_sigma_m", list(sigmas(calibration, row + 3))},
          {"turned_deg", list(kDegrees * turned(imu_T_camera, camera))},
          {"moved_m", list(moved)}};
}

// A number of the calibration in the state.
struct Parameter {
  std::string name, unit;
  double stated = 0, stated_sigma = 0, estimate = 0, sigma = 0;
  bool is_considered = false;

  // Its sigma has hardly decreased.
  bool is_observed() const { return sigma < kObserved * stated_sigma; }
  double moved() const { return (estimate - stated) / stated_sigma; }

  static constexpr double kObserved = 0.7;
  static constexpr double kFar = 3;  // sigmas of what was stated
};

double sigma_at(const Calibration& calibration, int row) {
  return std::sqrt(std::max(calibration.covariance(row, row), 0.0));
}

// The place of a number of the intrinsics among their rows, and its name.
struct IntrinsicsRow {
  int row = 0;
  std::string name, unit;
};

std::vector<IntrinsicsRow> intrinsics_rows(const Intrinsics& one, const Camera& camera) {
  std::vector<IntrinsicsRow> rows;
  if (one.has_lens) {
    rows = {{0, "fx", "px"}, {1, "fy", "px"}, {2, "cx", "px"}, {3, "cy", "px"}};
    const std::vector<std::string> names = coefficient_names(camera.distortion);
    for (std::size_t k = 0; k < one.coefficients.size(); ++k) {
      rows.push_back({6 + static_cast<int>(k), names[k], "1"});
    }
  }
  if (one.has_readout) rows.push_back({Intrinsics::kReadoutRow, "readout_time", "s"});
  return rows;
}

double value_of(const Intrinsics& one, int row) {
  if (row < 4) return one.projection[row];
  if (row == Intrinsics::kReadoutRow) return one.readout;
  return one.coefficients[static_cast<std::size_t>(row - 6)];
}

void add_extrinsics(const Calibration& c, std::span<const Camera> cameras,
                    const InertialSlamSettings& s, std::vector<Parameter>& all) {
  for (std::size_t i = 0; i < c.imu_T_camera.size(); ++i) {
    const Eigen::Vector3d rotation = turned(c.imu_T_camera[i], cameras[i]);
    const Eigen::Vector3d& p = c.imu_T_camera[i].p;
    const Eigen::Vector3d stated = cameras[i].cam_T_imu.inverse().p;
    const int row = 6 * static_cast<int>(i);
    for (int k = 0; k < 6; ++k) {
      const bool turns = k < 3;
      const char axis = "xyz"[k % 3];
      all.push_back({.name = fmt::format("imu_T_cam{}_{}{}", i, turns ? "turned_" : "", axis),
                     .unit = turns ? "rad" : "m",
                     .stated = turns ? 0 : stated[k - 3],
                     .stated_sigma = turns ? s.initial_extrinsic_rotation_sigma
                                           : s.initial_extrinsic_translation_sigma,
                     .estimate = turns ? rotation[k] : p[k - 3],
                     .sigma = sigma_at(c, row + k),
                     .is_considered = s.calibrate_extrinsics == Calibrate::kConsidered});
    }
  }
}

void add_intrinsics(const Calibration& c, std::span<const Camera> cameras,
                    const InertialSlamSettings& s, std::vector<Parameter>& all) {
  int first = c.intrinsics_row();
  for (std::size_t i = 0; i < c.intrinsics.size(); ++i) {
    const Intrinsics& one = c.intrinsics[i];
    const Intrinsics stated = intrinsics_of(cameras[i]);
    const std::vector<double> sigmas = intrinsics_sigmas(s, cameras[i]);
    for (const auto& [row, name, unit] : intrinsics_rows(one, cameras[i])) {
      const Calibrate use =
          row == Intrinsics::kReadoutRow ? s.calibrate_readout : s.calibrate_intrinsics;
      all.push_back({.name = fmt::format("cam{}_{}", i, name),
                     .unit = unit,
                     .stated = value_of(stated, row),
                     .stated_sigma = sigmas[static_cast<std::size_t>(row)],
                     .estimate = value_of(one, row),
                     .sigma = sigma_at(c, first + row),
                     .is_considered = use == Calibrate::kConsidered});
    }
    first += 6 * one.blocks();
  }
}

void add_imu(const Calibration& c, const InertialSlamSettings& s, std::vector<Parameter>& all) {
  if (!c.imu) return;
  const std::vector<std::string> names = c.imu->names();
  const Eigen::VectorXd values = c.imu->parameters(), sigmas = imu_sigmas(s, *c.imu);
  const auto unit = [](const std::string& name) {
    if (name.find("scale") != std::string::npos) return "1";
    return name.find("misalignment") != std::string::npos ? "rad" : "rad/s/(m/s^2)";
  };
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto row = static_cast<int>(i);
    all.push_back({.name = names[i],
                   .unit = unit(names[i]),
                   .stated_sigma = sigmas[row],
                   .estimate = values[row],
                   .sigma = sigma_at(c, c.imu_row() + row),
                   .is_considered = s.calibrate_imu == Calibrate::kConsidered});
  }
}

// In the order of the columns.
std::vector<Parameter> parameters_of(const Calibration& c, std::span<const Camera> cameras,
                                     const InertialSlamSettings& s) {
  std::vector<Parameter> all;
  add_extrinsics(c, cameras, s, all);
  if (c.time_offset) {
    all.push_back({.name = "time_offset",
                   .unit = "s",
                   .stated = s.initial_time_offset(),
                   .stated_sigma = s.initial_time_offset_sigma,
                   .estimate = *c.time_offset,
                   .sigma = sigma_at(c, c.time_offset_row()),
                   .is_considered = s.calibrate_time_offset == Calibrate::kConsidered});
  }
  add_intrinsics(c, cameras, s, all);
  add_imu(c, s, all);
  return all;
}

Json parameter_json(const Parameter& p) {
  return {{"name", p.name},
          {"unit", p.unit},
          {"stated", p.stated},
          {"stated_sigma", p.stated_sigma},
          {"estimate", p.estimate},
          {"sigma", p.sigma},
          {"use", p.is_considered ? "considered" : "estimated"},
          {"observed", !p.is_considered && p.is_observed()}};
}

}  // namespace

std::vector<std::string> calibration_columns(const InertialSlamSettings& settings,
                                             std::span<const Camera> cameras) {
  const auto calibration = stated_calibration(settings, cameras);
  std::vector<std::string> names;
  if (!calibration) return names;
  for (const Parameter& p : parameters_of(*calibration, cameras, settings)) {
    names.push_back(p.name);
  }
  return names;
}

void append_calibration(const Calibration& calibration, std::span<const Camera> cameras,
                        RunState& state) {
  for (const Parameter& p : parameters_of(calibration, cameras, {})) {
    state.extra.push_back(p.estimate);
    state.extra_sigma.push_back(p.sigma);
  }
}

Json calibration_json(const Calibration& calibration, std::span<const Camera> cameras,
                      const InertialSlamSettings& settings) {
  Json all = Json::object();
  for (std::size_t i = 0; i < calibration.imu_T_camera.size(); ++i) {
    all[fmt::format("cam{}", i)] = camera_json(calibration, i, cameras[i]);
  }
  if (calibration.time_offset) {
    all["time_offset"] = *calibration.time_offset;
    all["time_offset_sigma"] = sigma_at(calibration, calibration.time_offset_row());
    all["time_offset_moved"] = *calibration.time_offset - settings.initial_time_offset();
  }
  Json table = Json::array();
  for (const Parameter& p : parameters_of(calibration, cameras, settings)) {
    table.push_back(parameter_json(p));
  }
  all["parameters"] = table;
  return all;
}

std::vector<std::string> calibration_remarks(const Calibration& calibration,
                                             std::span<const Camera> cameras,
                                             const InertialSlamSettings& settings) {
  std::vector<std::string> unobserved, far;
  for (const Parameter& p : parameters_of(calibration, cameras, settings)) {
    const bool is_known = p.stated_sigma == 0;
    if (p.is_considered || is_known || p.name == "time_offset") continue;
    if (std::abs(p.moved()) > Parameter::kFar) {
      far.push_back(fmt::format("{} ({:.1f} sigma)", p.name, p.moved()));
    } else if (!p.is_observed()) {
      unobserved.push_back(p.name);
    }
  }
  std::vector<std::string> remarks;
  if (!unobserved.empty()) {
    remarks.push_back(
        fmt::format("calibration: the motion did not observe {}: they keep what was stated",
                    fmt::join(unobserved, ", ")));
  }
  if (!far.empty()) {
    remarks.push_back(fmt::format(
        "calibration: far from what was stated: {}; check the calibration, or the initial sigmas",
        fmt::join(far, ", ")));
  }
  return remarks;
}

}  // namespace chasles
