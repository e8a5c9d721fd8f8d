#include <chasles/recording/extrinsics.hpp>
#include <chasles/recording/testing.hpp>

namespace chasles {
namespace {

using test::Drive;
using test::drive;

SE3 malformed(const SE3& proper) { return {proper.R, -(proper.R.transpose() * proper.p)}; }

TEST(Extrinsics, ATurningDriveShowsTheLeverArm) {
  const Recording r = drive(Drive{});
  const SE3 proper = r.rig.cam0_T_imu;
  const auto favours_second = compare_extrinsics(r, malformed(proper), proper);
  EXPECT_GT(favours_second.sigmas, 10);
  EXPECT_LT(favours_second.second_cost, 1e-6);
  EXPECT_GT(favours_second.first_cost, 1);
  EXPECT_EQ(favours_second.steps, 59);
  const auto favours_first = compare_extrinsics(r, proper, malformed(proper));
  EXPECT_DOUBLE_EQ(favours_first.sigmas, -favours_second.sigmas);
}

// The noise of the ECE276A sets of 2020. It changes the predictions by more than the lever arm
// does.
TEST(Extrinsics, NoiseOfTheVelocitiesDoesNotDecide) {
  const Recording r =
      drive(Drive{.frames = 250, .tracks = 900, .speed_noise = 0.5, .rate_noise = 0.05});
  const SE3 proper = r.rig.cam0_T_imu;
  EXPECT_GT(compare_extrinsics(r, malformed(proper), proper).sigmas, 4);
  EXPECT_LT(compare_extrinsics(r, proper, malformed(proper)).sigmas, -4);
}

TEST(Extrinsics, AStraightDriveShowsNothing) {
  const Recording r = drive(Drive{.yaw_rate = 0});
  const SE3 proper = r.rig.cam0_T_imu;
  EXPECT_EQ(compare_extrinsics(r, malformed(proper), proper).steps, 0);
}

TEST(Extrinsics, AnEmptyRecordingShowsNothing) {
  EXPECT_EQ(compare_extrinsics(Recording{}, SE3{}, SE3{}).steps, 0);
  EXPECT_EQ(compare_extrinsics(drive(Drive{.frames = 1, .tracks = 10}), SE3{}, SE3{}).steps, 0);
}

}  // namespace
}  // namespace chasles
