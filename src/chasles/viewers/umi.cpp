#include <iterator>

#include <fmt/format.h>

#include <chasles/codec/numbers.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/viewers/path_at_frames.hpp>
#include <chasles/viewers/umi.hpp>

namespace chasles {
namespace {

// The states of ORB-SLAM3's tracking, which UMI's pipeline runs.
constexpr int kNotInitialised = 1, kTracking = 2, kLost = 4;

}  // namespace

std::string run_umi(const ReportRun& run, RunPath path, std::span<const Time> stamps) {
  const SE3 imu_T_cam0 = imu_T_camera(run.summary, 0);
  const auto poses = poses_at_frames(run, path, stamps);
  std::string text = "frame_idx,timestamp,state,is_lost,is_keyframe,x,y,z,q_x,q_y,q_z,q_w\n";
  bool initialised = false;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const auto row = [&](int state, const char* is_lost) {
      fmt::format_to(std::back_inserter(text), "{},{},{},{},", i,
                     seconds_text(stamps[i] - stamps[0]), state, is_lost);
    };
    if (!poses[i]) {
      row(initialised ? kLost : kNotInitialised, "true");
      text += "false,0,0,0,0,0,0,0\n";
      continue;
    }
    initialised = true;
    const SE3 world_T_cam0 = poses[i]->world_T_imu * imu_T_cam0;
    const Eigen::Vector4d q = unit_quaternion(world_T_cam0.R);
    const Eigen::Vector3d& p = world_T_cam0.p;
    row(kTracking, "false");
    fmt::format_to(std::back_inserter(text), "true,{},{},{},{},{},{},{}\n", p.x(), p.y(), p.z(),
                   q[0], q[1], q[2], q[3]);
  }
  return text;
}

}  // namespace chasles
