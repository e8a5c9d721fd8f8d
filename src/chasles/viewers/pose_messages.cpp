#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/viewers/foxglove.hpp>
#include <chasles/viewers/pose_messages.hpp>

namespace chasles {
namespace {

using Json = nlohmann::json;

// [theta; dp] has the rotation first; Foxglove has the position first.
std::vector<double> position_first(const Matrix6d& covariance) {
  std::vector<double> rows;
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) rows.push_back(covariance((i + 3) % 6, (j + 3) % 6));
  }
  return rows;
}

bool has_finite_pose(const RunState& s) {
  return s.world_T_imu.p.allFinite() && s.world_T_imu.R.allFinite();
}

SE3 motion(const Json& rows) {
  SE3 T;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    for (std::size_t j = 0; j < 3; ++j) {
      T.R(row, static_cast<Eigen::Index>(j)) = rows.at(i).at(j).get<double>();
    }
    T.p(row) = rows.at(i).at(3).get<double>();
  }
  return T;
}

}  // namespace

Json tf_message(const RunState& s) {
  if (!has_finite_pose(s)) return nullptr;
  return {{"transforms", Json::array({proto_transform(s.time, "world", "imu", s.world_T_imu)})}};
}

Json pose_in_world(Time time, const SE3& pose) {
  return {{"timestamp", proto_time(time)}, {"frame_id", "world"}, {"pose", proto_pose(pose)}};
}

Json pose_message(const RunState& s) {
  return has_finite_pose(s) ? pose_in_world(s.time, s.world_T_imu) : Json(nullptr);
}

Json odometry_message(const RunState& s) {
  if (!has_finite_pose(s)) return nullptr;
  return {{"timestamp", proto_time(s.time)},
          {"frame_id", "world"},
          {"body_frame_id", "imu"},
          {"pose", proto_pose(s.world_T_imu)},
          {"pose_covariance", position_first(s.pose_covariance)}};
}

Json location_message(const RunState& s, const SE3& truth_T_world,
                      const Georeference& georeference) {
  if (!has_finite_pose(s)) return nullptr;
  const Geodetic place = to_geodetic(georeference, truth_T_world * s.world_T_imu.p);
  const Eigen::Matrix3d P =
      truth_T_world.R * s.pose_covariance.bottomRightCorner<3, 3>() * truth_T_world.R.transpose();
  return {{"timestamp", proto_time(s.time)},
          {"frame_id", "imu"},
          {"latitude", place.latitude},
          {"longitude", place.longitude},
          {"altitude", place.altitude},
          {"position_covariance", std::vector<double>(P.data(), P.data() + P.size())},
          {"position_covariance_type", 3}};
}

Json cameras_message(const Json& summary, Time time) {
  const auto cameras = summary.find("cameras");
  if (cameras == summary.end() || !cameras->is_array() || cameras->empty()) return nullptr;
  Json transforms = Json::array();
  try {
    for (std::size_t k = 0; k < cameras->size(); ++k) {
      transforms.push_back(proto_transform(time, "imu", fmt::format("cam{}", k),
                                           motion(cameras->at(k).at("imu_T_cam"))));
    }
  } catch (const Json::exception&) {
    throw InputError("summary.json: cameras: expected imu_T_cam, 4 x 4 numbers, of each");
  }
  return {{"transforms", std::move(transforms)}};
}

}  // namespace chasles
