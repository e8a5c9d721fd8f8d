#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include <chasles/eval/chi2.hpp>
#include <chasles/initialise/initialiser_motion_testing.hpp>
#include <chasles/sim/inertial_sim.hpp>

// The initialisation on simulated scenes: duration, errors, consistency, and conditions.

namespace chasles {
namespace {

using namespace test;

InertialScene scene_of(const std::string& name) {
  InertialScene scene = inertial_scene(name);
  scene.settings.sections = 1;
  return scene;
}

// The distribution of the scenes' biases, and the posterior without inflation.
InitialiserSettings exact() {
  InitialiserSettings settings;
  settings.accelerometer_bias_sigma = 0.02;
  settings.gyroscope_bias_sigma = 0.005236;
  settings.inflation = 1;
  return settings;
}

Study study(const InertialScene& scene, int runs, const InitialiserSettings& settings, double from,
            double from_step) {
  Study result;
  const Spline motion = inertial_motion(scene);
  for (int run = 0; run < runs; ++run) {
    const Recording recording = simulate_inertial(scene, static_cast<std::uint64_t>(run));
    result.add(initialise(recording, from + from_step * run, 6, settings), recording, motion);
  }
  return result;
}

const Requirement* unmet(const test::StartOutcome& outcome, const std::string& name) {
  for (const Requirement& r : outcome.requirements) {
    if (!r.met && r.name.find(name) != std::string::npos) return &r;
  }
  return nullptr;
}

TEST(Initialiser, StartsInMotionWithOneCameraAndKnowsHowWrongItIs) {
  const Study hall = study(scene_of("hallway"), 24, exact(), 1, 0.11);
  hall.print("hallway mono");
  EXPECT_EQ(hall.started, 24);
  EXPECT_LT(median(hall.seconds), 1.3);
  EXPECT_LT(median(hall.velocity), 0.1);
  EXPECT_LT(median(hall.scale), 0.08);
  EXPECT_LT(median(hall.tilt), 1 / kDegrees);
  EXPECT_LT(median(hall.gyroscope), 0.003);
  // 11 degrees of freedom; correct views that were removed as outliers increase it a little.
  EXPECT_GT(hall.mean_nees(), chi2_band(11, 24, 0.99).low);
  EXPECT_LT(hall.mean_nees(), 1.2 * chi2_band(11, 24, 0.99).high);
}

TEST(Initialiser, StartsInMotionAroundASmallObject) {
  const Study table = study(scene_of("turntable"), 20, exact(), 1, 0.3);
  table.print("turntable mono");
  EXPECT_GE(table.started, 18);
  EXPECT_LT(median(table.scale), 0.08);
  EXPECT_LT(median(table.tilt), 1 / kDegrees);
  EXPECT_LT(table.mean_nees(), 1.5 * 11);
}

TEST(Initialiser, TwoCamerasNeedLessTime) {
  InertialScene scene = scene_of("hallway");
  scene.settings.cameras = 2;
  const Study stereo = study(scene, 20, exact(), 1, 0.11);
  stereo.print("hallway stereo");
  EXPECT_EQ(stereo.started, 20);
  EXPECT_LT(median(stereo.seconds), 0.9);
  EXPECT_LT(median(stereo.velocity), 0.05);
  EXPECT_TRUE(chi2_band(11, 20, 0.999).contains(stereo.mean_nees())) << stereo.mean_nees();
}

TEST(Initialiser, StartsAtStandstillWithinASecond) {
  InertialScene scene = scene_of("hallway");
  scene.settings.rest_duration = 3;
  scene.settings.start_duration = 1;
  InitialiserSettings settings = exact();
  settings.inflation = 10;  // has no effect on a static initialisation
  const Study standstill = study(scene, 20, settings, 0.2, 0);
  standstill.print("standstill");
  EXPECT_EQ(standstill.started, 20);
  EXPECT_LT(median(standstill.seconds), 1);
  // The velocity is exactly 0: eight degrees of freedom remain.
  EXPECT_TRUE(chi2_band(8, 20, 0.999).contains(standstill.mean_nees())) << standstill.mean_nees();
}

TEST(Initialiser, OneObservationOfFiveMayBeWrong) {
  InertialScene scene = scene_of("hallway");
  scene.settings.outlier_fraction = 0.2;
  scene.settings.landmarks_in_view = 60;
  const Study wrong = study(scene, 10, exact(), 1, 0.11);
  wrong.print("20 % outlying observations");
  EXPECT_GE(wrong.started, 8);
  EXPECT_LT(median(wrong.velocity), 0.15);
}

// Every fifth track is wrong: it drifts.
TEST(Initialiser, OneTrackOfFiveMayBeWrong) {
  InertialScene scene = scene_of("hallway");
  scene.settings.landmarks_in_view = 60;
  const Spline motion = inertial_motion(scene);
  Study wrong;
  for (int run = 0; run < 10; ++run) {
    Recording recording = simulate_inertial(scene, static_cast<std::uint64_t>(run));
    for (FeatureFrame& frame : recording.frames) {
      const double t = to_seconds(frame.time - recording.frames.front().time);
      for (PixelObservation& o : frame.pixels) {
        if (o.landmark % 5 != 0) continue;
        const double angle = static_cast<double>(o.landmark);
        o.pixel += 40 * t * Eigen::Vector2d(std::cos(angle), std::sin(angle));
      }
    }
    wrong.add(initialise(recording, 1 + 0.11 * run, 6, exact()), recording, motion);
  }
  wrong.print("20 % wrong tracks");
  // A track that drifts along its epipolar line appears as a nearer point for a while, which makes
  // the start overconfident.
  EXPECT_GE(wrong.started, 8);
  EXPECT_LT(median(wrong.velocity), 0.2);
  EXPECT_LT(median(wrong.tilt), 1.2 / kDegrees);
  EXPECT_LT(wrong.mean_nees(), 3 * 11);
}

// A straight line at constant speed and attitude: the accelerometer does not determine the scale.
Recording constant_velocity() {
  InertialScene scene = inertial_scene("trajectory");
  for (int i = 0; i <= 100; ++i) {
    StampedPose& pose = scene.path.emplace_back();
    pose.time = from_seconds(0.1 * i);
    pose.pose.p.x() = 0.1 * i;
  }
  return simulate_inertial(scene, 0);
}

TEST(Initialiser, ConstantVelocityWithOneCameraIsRejectedForItsScale) {
  const test::StartOutcome outcome = initialise(constant_velocity(), 1, 7, {});
  EXPECT_FALSE(outcome.start);
  EXPECT_GT(outcome.counts.attempts, 10);
  const Requirement* scale = unmet(outcome, "scale");
  ASSERT_NE(scale, nullptr) << outcome.why_not;
  EXPECT_GT(scale->measured, scale->threshold);
  EXPECT_NE(outcome.why_not.find("scale"), std::string::npos);
}

TEST(Initialiser, RotationWithoutTranslationIsRejectedForItsParallax) {
  InertialScene scene = inertial_scene("trajectory");
  scene.settings.camera_x = scene.settings.camera_y = scene.settings.camera_z = 0;
  for (int i = 0; i <= 120; ++i) {
    const double t = 0.05 * i;
    StampedPose& pose = scene.path.emplace_back();
    pose.time = from_seconds(t);
    pose.pose.R = so3::exp({0, 0, 0.4 * std::sin(2 * t)});
  }
  const test::StartOutcome outcome = initialise(simulate_inertial(scene, 0), 0.2, 5, {});
  EXPECT_FALSE(outcome.start);
  EXPECT_NE(unmet(outcome, "parallax"), nullptr) << outcome.why_not;
}

TEST(Initialiser, WithoutTracksItSaysSo) {
  Recording recording = simulate_inertial(scene_of("hallway"), 0);
  for (FeatureFrame& frame : recording.frames) frame.pixels.clear();
  const test::StartOutcome outcome = initialise(recording, 1, 3, {});
  EXPECT_FALSE(outcome.start);
  ASSERT_NE(unmet(outcome, "tracks"), nullptr) << outcome.why_not;
  EXPECT_EQ(unmet(outcome, "tracks")->measured, 0);
}

TEST(Initialiser, PixelsAnywhereAndSamplesOfNothingAreRejected) {
  InertialScene scene = scene_of("hallway");
  Recording idle = simulate_inertial(scene, 0);
  for (ImuSample& sample : idle.imu) sample.specific_force_imu.setZero();
  EXPECT_FALSE(initialise(idle, 1, 4, {}).start);
  scene.settings.outlier_fraction = 1;
  const test::StartOutcome outcome = initialise(simulate_inertial(scene, 0), 1, 4, {});
  EXPECT_FALSE(outcome.start);
  EXPECT_NE(unmet(outcome, "tracks"), nullptr) << outcome.why_not;
}

TEST(Initialiser, AGapOfSamplesBeginsTheWindowAnew) {
  const InertialScene scene = scene_of("hallway");
  Recording recording = simulate_inertial(scene, 0);
  const Time gap = recording.frames.front().time + from_seconds(1.5);
  std::erase_if(recording.imu, [&](const ImuSample& sample) {
    return sample.time > gap && sample.time < gap + from_seconds(0.2);
  });
  const test::StartOutcome outcome = initialise(recording, 1, 6, exact());
  ASSERT_TRUE(outcome.start);
  EXPECT_EQ(outcome.counts.restarts, 1);
  EXPECT_GT(outcome.start->time, gap);
  EXPECT_GT(outcome.seconds, 1.5);
}

TEST(Initialiser, GivesTheSameBytesTwice) {
  const Recording recording = simulate_inertial(scene_of("hallway"), 0);
  const test::StartOutcome a = initialise(recording, 1, 6, {}), b = initialise(recording, 1, 6, {});
  ASSERT_TRUE(a.start && b.start);
  EXPECT_EQ(a.start->v_nav, b.start->v_nav);
  EXPECT_EQ(a.start->nav_T_imu.R, b.start->nav_T_imu.R);
  EXPECT_EQ(*a.start->covariance, *b.start->covariance);
}

}  // namespace
}  // namespace chasles
