#include <chasles/filter/inertial_testing.hpp>
#include <chasles/filter/readout.hpp>

namespace chasles {
namespace {

using Eigen::Vector3d;

const Vector3d kGravity(0, 0, -kStandardGravity);

// A hand-held device that shakes, sampled at 200 Hz over 30 ms.
std::vector<ImuInterval> shaking() {
  std::vector<ImuInterval> intervals;
  for (int i = 0; i < 6; ++i) {
    const double t = 0.005 * (i + 0.5);
    intervals.push_back(
        {.tau = 0.005,
         .specific_force_imu = Vector3d(2, -1, 9.8) + 40 * t * Vector3d(1, 0.5, -1),
         .angular_rate_imu = Vector3d(1.5, -2, 0.7) + 30 * t * Vector3d(-1, 0.4, 1)});
  }
  return intervals;
}

InertialState some_state() {
  InertialState state;
  state.world_T_imu = {so3::exp({0.5, -1, 2}), {3, 1, 2}};
  state.v_world = {1.5, -0.8, 0.3};
  state.accelerometer_bias = {0.05, -0.1, 0.02};
  state.gyroscope_bias = {0.01, 0.02, -0.03};
  return state;
}

// The motion by the strapdown integral of the first `count` intervals.
SE3 integrated(InertialState state, const std::vector<ImuInterval>& intervals, int count) {
  const SE3 world_T_start = state.world_T_imu;
  for (int i = 0; i < count; ++i) {
    state = integrate(state, intervals[static_cast<std::size_t>(i)], kGravity);
  }
  return world_T_start.inverse() * state.world_T_imu;
}

TEST(MeasuredReadout, IsTheStrapdownIntegral) {
  const std::vector<ImuInterval> intervals = shaking();
  const InertialState state = some_state();
  const MeasuredReadout measured = measured_readout(intervals, state.biases());
  const ReadoutMotion motion = measured.motion(state.world_T_imu.R, state.v_world, kGravity);
  for (int count = 0; count <= 6; ++count) {
    const SE3 expected = integrated(state, intervals, count), found = motion.after(0.005 * count);
    const double exact = count % 3 == 0 ? 1e-12 : 2e-5;  // in the middle and at the end; elsewhere
    EXPECT_LT(so3::log(found.R.transpose() * expected.R).norm(), exact) << count;
    EXPECT_LT((found.p - expected.p).norm(), count % 6 == 0 ? 1e-12 : 5e-5) << count;
  }
  EXPECT_TRUE(test::agree(measured.rotation_after(0.03), motion.after(0.03).R, 1e-15));
}

TEST(MeasuredReadout, WithoutSamplesOnlyTheVelocityMoves) {
  const MeasuredReadout measured = measured_readout({}, Vector6d::Zero());
  const ReadoutMotion motion =
      measured.motion(Eigen::Matrix3d::Identity(), {1, 0, 0}, Vector3d::Zero());
  EXPECT_EQ(motion.after(0.02).R, Eigen::Matrix3d::Identity());
  EXPECT_TRUE(test::agree(motion.after(0.02).p, Vector3d(0.02, 0, 0), 1e-15));
}

TEST(LongestReadout, IsThatOfTheSlowestCamera) {
  std::vector<Camera> cameras = test::inertial_cameras();
  EXPECT_EQ(longest_readout(cameras), 0);
  cameras[1].shutter.readout = 0.02;
  cameras[2].shutter.readout = 0.01;
  EXPECT_EQ(longest_readout(cameras), 0.02);
}

}  // namespace
}  // namespace chasles
