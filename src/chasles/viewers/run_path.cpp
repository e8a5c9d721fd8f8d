#include <algorithm>
#include <iterator>
#include <string>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/viewers/run_path.hpp>

namespace chasles {

bool is_finite(const SE3& pose) { return pose.p.allFinite() && pose.R.allFinite(); }

std::vector<SmoothedPose> path_poses(const Run& run, RunPath path) {
  std::vector<SmoothedPose> poses = run.smoothed;
  if (path == RunPath::kStates) {
    poses.clear();
    for (const RunState& s : run.states) {
      poses.push_back(
          {.time = s.time, .world_T_imu = s.world_T_imu, .pose_covariance = s.pose_covariance});
    }
  }
  if (poses.empty()) {
    throw InputError(fmt::format("run '{}' has no {}, expected {}", run.name,
                                 path == RunPath::kSmoothed ? "smoothed.csv" : "row in states.csv",
                                 path == RunPath::kSmoothed
                                     ? "the run of a filter with exact_map (docs/map.md)"
                                     : "a run that was initialised"));
  }
  std::erase_if(poses, [](const SmoothedPose& s) { return !is_finite(s.world_T_imu); });
  if (poses.empty()) {
    throw InputError(fmt::format("run '{}': none of its poses is finite: it diverged", run.name));
  }
  return poses;
}

void append_tum(Time time, const SE3& pose, std::string& text) {
  const Eigen::Vector4d q = unit_quaternion(pose.R);
  const Eigen::Vector3d& p = pose.p;
  fmt::format_to(std::back_inserter(text), "{} {} {} {} {} {} {} {}", seconds_text(time), p.x(),
                 p.y(), p.z(), q[0], q[1], q[2], q[3]);
}

std::optional<std::size_t> extra_vector_at(const Run& run, std::string_view name) {
  const auto found = std::ranges::find(run.extra_names, fmt::format("{}_x", name));
  const auto at = static_cast<std::size_t>(found - run.extra_names.begin());
  if (at + 3 > run.extra_names.size()) return std::nullopt;
  return at;
}

SE3 imu_T_camera(std::string_view summary, std::size_t camera) {
  const std::string where = fmt::format("summary.json: cameras: imu_T_cam of camera {}", camera);
  Eigen::Matrix4d T;
  try {
    const auto rows = nlohmann::json::parse(summary).at("cameras").at(camera).at("imu_T_cam");
    for (int i = 0; i < 4; ++i) {
      for (int j = 0; j < 4; ++j) T(i, j) = rows.at(i).at(j).get<double>();
    }
  } catch (const nlohmann::json::exception&) {
    throw InputError(where + ": expected 4 x 4 numbers, as `chasles run` writes them");
  }
  return checked_motion(where, T);
}

std::size_t recorded_camera(std::string_view summary, std::size_t camera) {
  const auto json = nlohmann::json::parse(summary, nullptr, false);
  const auto place = nlohmann::json::json_pointer(fmt::format("/cameras/{}/number", camera));
  const bool has_number =
      !json.is_discarded() && json.contains(place) && json.at(place).is_number_unsigned();
  return has_number ? json.at(place).get<std::size_t>() : camera;
}

}  // namespace chasles
