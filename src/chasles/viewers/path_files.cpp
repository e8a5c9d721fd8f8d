#include <array>
#include <iterator>
#include <vector>

#include <fmt/format.h>

#include <chasles/codec/numbers.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/viewers/path_files.hpp>

namespace chasles {
namespace {

constexpr const char* kEurocPose =
    "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], "
    "q_RS_z []";

// A vector of EuRoC's states, and its name in states.csv.
struct EurocVector {
  const char* columns;
  const char* name;
};

constexpr std::array kEurocVectors{
    EurocVector{", v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1]", "velocity"},
    EurocVector{", b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad s^-1], b_w_RS_S_z [rad s^-1]",
                "gyroscope_bias"},
    EurocVector{", b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]",
                "accelerometer_bias"}};

// The rows of the vectors of the states with finite poses; none unless the run has all of them.
std::vector<std::string> euroc_vectors(const Run& run) {
  std::vector<std::size_t> columns;
  for (const EurocVector& vector : kEurocVectors) {
    const auto at = extra_vector_at(run, vector.name);
    if (!at) return {};
    columns.push_back(*at);
  }
  std::vector<std::string> rows;
  for (const RunState& s : run.states) {
    if (!is_finite(s.world_T_imu)) continue;
    std::string& row = rows.emplace_back();
    for (const std::size_t at : columns) {
      row += fmt::format(",{},{},{}", s.extra[at], s.extra[at + 1], s.extra[at + 2]);
    }
  }
  return rows;
}

}  // namespace

std::string run_tum(const Run& run, RunPath path) {
  std::string text = "# t tx ty tz qx qy qz qw\n";
  for (const SmoothedPose& s : path_poses(run, path)) {
    append_tum(s.time, s.world_T_imu, text);
    text += '\n';
  }
  return text;
}

KittiFiles run_kitti(const ReportRun& run, RunPath path) {
  const SE3 imu_T_cam0 = imu_T_camera(run.summary, 0);
  const std::vector<SmoothedPose> poses = path_poses(run.run, path);
  const SE3 first_T_world = (poses.front().world_T_imu * imu_T_cam0).inverse();
  KittiFiles files;
  for (const SmoothedPose& s : poses) {
    const SE3 T = first_T_world * s.world_T_imu * imu_T_cam0;
    for (int i = 0; i < 3; ++i) {
      fmt::format_to(std::back_inserter(files.poses), "{}{} {} {} {}", i == 0 ? "" : " ", T.R(i, 0),
                     T.R(i, 1), T.R(i, 2), T.p(i));
    }
    files.poses += '\n';
    files.times += seconds_text(s.time) + '\n';
  }
  return files;
}

std::string run_euroc(const Run& run, RunPath path) {
  const std::vector<SmoothedPose> poses = path_poses(run, path);
  // The smoothed path has poses alone.
  const std::vector<std::string> vectors =
      path == RunPath::kStates ? euroc_vectors(run) : std::vector<std::string>{};
  std::string text = kEurocPose;
  if (!vectors.empty()) {
    for (const EurocVector& vector : kEurocVectors) text += vector.columns;
  }
  text += '\n';
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Eigen::Vector4d q = unit_quaternion(poses[i].world_T_imu.R);
    const Eigen::Vector3d& p = poses[i].world_T_imu.p;
    fmt::format_to(std::back_inserter(text), "{},{},{},{},{},{},{},{}{}\n", poses[i].time.count(),
                   p.x(), p.y(), p.z(), q[3], q[0], q[1], q[2], vectors.empty() ? "" : vectors[i]);
  }
  return text;
}

}  // namespace chasles
