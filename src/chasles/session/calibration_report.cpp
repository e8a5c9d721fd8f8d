#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/constants.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/session/calibration_report.hpp>

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

}  // namespace

std::vector<std::string> calibration_columns(const InertialSlamSettings& settings,
                                             std::size_t cameras) {
  std::vector<std::string> names;
  for (std::size_t i = 0; settings.calibrate_extrinsics && i < cameras; ++i) {
    for (const char* of : {"turned_x", "turned_y", "turned_z", "x", "y", "z"}) {
      names.push_back(fmt::format("imu_T_cam{}_{}", i, of));
    }
  }
  if (settings.estimates_time_offset()) names.emplace_back("time_offset");
  return names;
}

void append_calibration(const Calibration& calibration, std::span<const Camera> cameras,
                        RunState& state) {
  for (std::size_t i = 0; i < calibration.imu_T_camera.size(); ++i) {
    const Eigen::Vector3d rotation = turned(calibration.imu_T_camera[i], cameras[i]);
    const Eigen::Vector3d& p = calibration.imu_T_camera[i].p;
    state.extra.insert(state.extra.end(), rotation.begin(), rotation.end());
    state.extra.insert(state.extra.end(), p.begin(), p.end());
  }
  if (calibration.time_offset) state.extra.push_back(*calibration.time_offset);
  const Eigen::VectorXd sigma = calibration.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  state.extra_sigma.insert(state.extra_sigma.end(), sigma.begin(), sigma.end());
}

Json calibration_json(const Calibration& calibration, std::span<const Camera> cameras,
                      double stated_time_offset) {
  Json all = Json::object();
  for (std::size_t i = 0; i < calibration.imu_T_camera.size(); ++i) {
    all[fmt::format("cam{}", i)] = camera_json(calibration, i, cameras[i]);
  }
  if (calibration.time_offset) {
    const Eigen::Index last = calibration.covariance.rows() - 1;
    all["time_offset"] = *calibration.time_offset;
    all["time_offset_sigma"] = std::sqrt(std::max(calibration.covariance(last, last), 0.0));
    all["time_offset_moved"] = *calibration.time_offset - stated_time_offset;
  }
  return all;
}

}  // namespace chasles
