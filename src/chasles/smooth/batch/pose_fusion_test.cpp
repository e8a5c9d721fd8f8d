#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/smooth/batch/pose_fusion.hpp>
#include <chasles/smooth/batch/smooth_testing.hpp>

namespace chasles {
namespace {

using test::small_scene;
using test::SmallScene;

constexpr double kPosition = 0.005, kRotation = 0.002;

// Ten seconds, ten poses a second, a hundred samples.
SmallScene flight() { return small_scene({.frames = 101, .landmarks = 0}); }

Trajectory truth_of(const SmallScene& scene) {
  Trajectory poses;
  for (const TimedMotion& m : scene.truth) poses.push_back({m.time, m.state.world_T_imu});
  return poses;
}

Trajectory jittered(Trajectory poses) {
  test::Random random(7);
  for (StampedPose& pose : poses) {
    pose.pose.p += kPosition * Eigen::Vector3d(random.normal_vector(3));
    pose.pose.R = so3::exp(kRotation * Eigen::Vector3d(random.normal_vector(3))) * pose.pose.R;
  }
  return poses;
}

PoseFusionSettings settings_of(const SmallScene& scene) {
  return {.position_sigma = kPosition,
          .rotation_sigma = kRotation,
          .noise = scene.input.noise,
          .imu = scene.input.imu};
}

struct PoseErrors {
  double position = 0, rotation = 0;  // root mean square
};

// Of the poses at the times of the truth.
PoseErrors errors(const Trajectory& poses, const Trajectory& truth) {
  PoseErrors e;
  std::size_t k = 0;
  for (const StampedPose& pose : poses) {
    if (k == truth.size() || pose.time != truth[k].time) continue;
    e.position += (pose.pose.p - truth[k].pose.p).squaredNorm();
    e.rotation += so3::log(pose.pose.R * truth[k].pose.R.transpose()).squaredNorm();
    ++k;
  }
  EXPECT_EQ(k, truth.size()) << "every pose is there";
  const auto count = static_cast<double>(truth.size());
  return {std::sqrt(e.position / count), std::sqrt(e.rotation / count)};
}

TEST(PoseFusion, TakesTheJitterOutOfPoses) {
  const SmallScene scene = flight();
  const Trajectory truth = truth_of(scene), poses = jittered(truth);
  const PoseFusion fused = fuse_poses(poses, scene.input.samples, settings_of(scene));
  const PoseErrors before = errors(poses, truth), after = errors(fused.world_T_imu, truth);
  EXPECT_GT(before.position, kPosition);
  EXPECT_LT(after.position, before.position / 2);
  EXPECT_LT(after.rotation, before.rotation / 3);
  EXPECT_NEAR(fused.position_moved, before.position, after.position);
  EXPECT_NEAR(fused.rotation_moved, before.rotation, after.rotation);
  EXPECT_NEAR(fused.cost_per_dof, 1, 3 * std::sqrt(2 / 600.0)) << "chi^2 of 6 rows a pose";
}

TEST(PoseFusion, LeavesWhatAgreesAsItIs) {
  SmallScene scene = small_scene({.frames = 41, .noise = 0, .landmarks = 0});
  const Trajectory truth = truth_of(scene);
  const PoseFusion fused = fuse_poses(truth, scene.input.samples, settings_of(scene));
  EXPECT_LT(fused.position_moved, 1e-7);
  EXPECT_LT(fused.rotation_moved, 1e-7);
  EXPECT_LT(fused.cost_per_dof, 1e-6);
}

// A truth at every sample against one at every tenth.
TEST(PoseFusion, ShowsTheMotionBetweenPoses) {
  const SmallScene dense = small_scene({.frames = 401, .seconds_a_frame = 0.01, .landmarks = 0});
  const Trajectory all = truth_of(dense);
  Trajectory poses;
  for (std::size_t k = 0; k < all.size(); k += 10) poses.push_back(all[k]);
  const PoseFusion fused = fuse_poses(poses, dense.input.samples, settings_of(dense));
  ASSERT_EQ(fused.world_T_imu.size(), all.size());
  const PoseErrors e = errors(fused.world_T_imu, all);
  EXPECT_LT(e.position, 1e-3);
  EXPECT_LT(e.rotation, 1e-3);
}

TEST(PoseFusion, APoseThatIsFarOffHardlyCounts) {
  const SmallScene scene = flight();
  const Trajectory truth = truth_of(scene);
  Trajectory poses = jittered(truth);
  poses[50].pose.p += Eigen::Vector3d(1, 0, 0);
  const PoseFusion fused = fuse_poses(poses, scene.input.samples, settings_of(scene));
  EXPECT_LT(errors(fused.world_T_imu, truth).position, kPosition);
}

TEST(PoseFusion, RejectsWhatIsShortOrHasGaps) {
  const SmallScene scene = flight();
  const Trajectory truth = truth_of(scene);
  const auto fuse = [&](const Trajectory& poses, const std::vector<ImuSample>& samples) {
    return fuse_poses(poses, samples, settings_of(scene));
  };
  EXPECT_THROW(fuse({}, scene.input.samples), InputError);
  EXPECT_THROW(fuse(truth, {}), InputError);
  EXPECT_THROW(fuse({truth.begin(), truth.begin() + 20}, scene.input.samples), InputError);
  Trajectory gap = truth;
  gap.erase(gap.begin() + 40, gap.begin() + 46);
  EXPECT_THROW(fuse(gap, scene.input.samples), InputError);
  std::vector<ImuSample> samples = scene.input.samples;
  samples.erase(samples.begin() + 400, samples.begin() + 460);
  EXPECT_THROW(fuse(truth, samples), InputError);
  Trajectory backwards = truth;
  std::swap(backwards[10], backwards[11]);
  EXPECT_THROW(fuse(backwards, scene.input.samples), InputError);
  PoseFusionSettings no_noise = settings_of(scene);
  no_noise.noise.gyroscope_noise_density = 0;
  EXPECT_THROW(fuse_poses(truth, scene.input.samples, no_noise), InputError);
}

}  // namespace
}  // namespace chasles
