#include <gtest/gtest.h>

#include <chasles/lie/so3.hpp>
#include <chasles/reconstruct/later_poses.hpp>

namespace chasles {
namespace {

using std::chrono::milliseconds;

TEST(LaterPoses, AreBetweenTheStates) {
  auto run = chasles::Run{};
  for (int i = 0; i < 3; ++i) {
    RunState& state = run.states.emplace_back();
    state.time = milliseconds(100 * i);
    state.world_T_imu = {so3::exp({0, 0, 0.1 * i}), {1.0 * i, 0, 0}};
  }
  const auto poses = path_poses(run, RunPath::kStates);
  const LaterPoses later(run, RunPath::kStates, 0.02);
  const SE3 found = later.after(poses[1]).value();
  EXPECT_LT((found.p - Eigen::Vector3d(1.2, 0, 0)).norm(), 1e-12);
  EXPECT_LT((found.R - so3::exp({0, 0, 0.12})).norm(), 1e-12);
  EXPECT_FALSE(later.after(poses[2])) << "the path ends";
  // A global shutter: the pose itself, to the last bit.
  const LaterPoses now(run, RunPath::kStates, 0);
  EXPECT_EQ(now.after(poses[2]).value().R, poses[2].world_T_imu.R);
}

}  // namespace
}  // namespace chasles
