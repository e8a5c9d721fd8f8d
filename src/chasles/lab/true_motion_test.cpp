#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/lab/true_motion.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/sim/inertial_sim.hpp>

namespace chasles {
namespace {

// A walk, as a scene whose truth and samples are treated as real ones.
InertialScene real_scene(const SE3& leaning) {
  InertialScene hall = inertial_scene("hallway");
  hall.settings.hall_length = 8;
  hall.settings.hall_width = 8;
  hall.settings.sections = 1;
  const Recording recording = simulate_inertial(hall);
  InertialScene scene = inertial_scene("trajectory");
  scene.settings.imu_convention = hall.settings.imu_convention;
  scene.settings.accelerometer_noise_density = hall.settings.accelerometer_noise_density;
  scene.settings.accelerometer_random_walk = hall.settings.accelerometer_random_walk;
  scene.settings.gyroscope_noise_density = hall.settings.gyroscope_noise_density;
  scene.settings.gyroscope_random_walk = hall.settings.gyroscope_random_walk;
  scene.imu = recording.imu;
  for (const StampedPose& pose : recording.truth) {
    scene.path.push_back({pose.time, leaning * pose.pose});
  }
  return scene;
}

double angle_between(const SE3& a, const SE3& b) { return so3::log(a.R * b.R.transpose()).norm(); }

TEST(TrueMotion, StandsUprightAndAgreesWithTheSamples) {
  const InertialScene upright = real_scene({});
  InertialScene scene = real_scene({so3::exp({0.05, 0, 0}), Eigen::Vector3d::Zero()});
  const std::string remark = make_agree(scene);
  EXPECT_TRUE(remark.starts_with("truth: rotated upright by ")) << remark;
  std::size_t k = 0;
  for (const StampedPose& pose : scene.path) {
    while (k + 1 < upright.path.size() && upright.path[k].time < pose.time) ++k;
    if (upright.path[k].time != pose.time) continue;
    EXPECT_LT(angle_between(pose.pose, upright.path[k].pose), 0.01);
  }
  EXPECT_GT(scene.path.size(), 2 * upright.path.size()) << "samples between poses";
}

TEST(TrueMotion, SaysWhatIsMissing) {
  InertialScene scene = real_scene({});
  scene.path.resize(2);
  EXPECT_THROW(make_agree(scene), InputError);
}

}  // namespace
}  // namespace chasles
