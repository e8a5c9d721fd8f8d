#include <chasles/slam/step_testing.hpp>
#include <chasles/slam/study_hooks.hpp>

namespace chasles {
namespace {

TEST(StudyHooks, DoNothingByDefault) {
  StudyHooks hooks({}, {});
  test::Random random(4);
  SlamContext x = test::some_context(random);
  EXPECT_FALSE(hooks.compose_when_due(x.filter, from_seconds(100)));
  EXPECT_EQ(hooks.noise_inflation({}), 1);
  Measurement z;
  ASSERT_TRUE(measure_pixel(x.camera(0), 1, x.state(), 0, {300, 200}, x.linearisation(), 0, z));
  const Measurement analytic = z;
  hooks.differentiate(x.filter, x.camera(0), z);
  EXPECT_EQ(z.d_core, analytic.d_core);
  EXPECT_EQ(z.d_landmark, analytic.d_landmark);
}

TEST(StudyHooks, NumericDerivativesAreNearTheAnalyticOnesButNotTheSame) {
  InertialSlamSettings settings;
  settings.numeric_jacobians = true;
  const StudyHooks hooks(settings, {});
  test::Random random(4);
  const SlamContext x = test::some_context(random);
  Measurement z;
  ASSERT_TRUE(measure_pixel(x.camera(0), 1, x.state(), 0, {300, 200}, x.linearisation(), 0, z));
  const Measurement analytic = z;
  hooks.differentiate(x.filter, x.camera(0), z);
  EXPECT_TRUE(test::agree(z.d_landmark, analytic.d_landmark, 1e-5));
  EXPECT_NE(z.d_landmark, analytic.d_landmark);
}

TEST(StudyHooks, InflateTheNoiseOfYoungLandmarksAndComposeOnTime) {
  InertialSlamSettings settings;
  settings.noise_inflation = 4;
  settings.noise_inflation_frames = 10;
  settings.composition_interval = 1;
  StudyHooks hooks(settings, {});
  EXPECT_DOUBLE_EQ(hooks.noise_inflation({.observations = 0}), 5);
  EXPECT_DOUBLE_EQ(hooks.noise_inflation({.observations = 5}), 3);
  EXPECT_DOUBLE_EQ(hooks.noise_inflation({.observations = 50}), 1);
  test::Random random(5);
  SlamContext x = test::some_context(random);
  EXPECT_FALSE(hooks.compose_when_due(x.filter, from_seconds(0.9)));
  EXPECT_TRUE(hooks.compose_when_due(x.filter, from_seconds(1.1)));
  EXPECT_LT(x.state().world_T_imu.p.norm(), 1e-9) << "the world is the IMU's frame";
  EXPECT_FALSE(hooks.compose_when_due(x.filter, from_seconds(1.9)));
}

}  // namespace
}  // namespace chasles
