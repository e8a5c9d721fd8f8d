#include <limits>

#include <chasles/slam/clone_window.hpp>
#include <chasles/slam/innovation_correlation.hpp>
#include <chasles/slam/step_testing.hpp>
#include <chasles/slam/study_hooks.hpp>
#include <chasles/slam/undelayed_initialiser.hpp>
#include <chasles/slam/usable_observations.hpp>

// The small classes of the steps.
namespace chasles {
namespace {

TEST(UsableObservations, AreFiniteOfKnownCamerasAndTheFirstOfTheirKind) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const std::vector<PixelObservation> pixels{{.landmark = 5, .camera = 0, .pixel = {1, 1}},
                                             {.landmark = 4, .camera = 1, .pixel = {2, 2}},
                                             {.landmark = 5, .camera = 0, .pixel = {3, 3}},
                                             {.landmark = 5, .camera = 1, .pixel = {4, 4}},
                                             {.landmark = 6, .camera = 2, .pixel = {5, 5}},
                                             {.landmark = 7, .camera = -1, .pixel = {6, 6}},
                                             {.landmark = 8, .camera = 0, .pixel = {nan, 7}}};
  UsableObservations usable;
  EXPECT_EQ(usable.among(pixels, 2),
            (std::vector<const PixelObservation*>{&pixels[0], &pixels[1], &pixels[3]}));
}

TEST(InnovationCorrelation, IsThatOfSuccessiveFrames) {
  const std::vector<PixelObservation> pixels{{.landmark = 1}, {.landmark = 2}};
  const auto report = [](double a, double b) {
    UpdateReport r;
    r.accepted = {true, true};
    r.whitened = {Eigen::Vector2d(a, 0), Eigen::Vector2d(b, 0)};
    return r;
  };
  InnovationCorrelation correlation;
  Estimate first, second, third;
  correlation.add(test::pointers(pixels), report(1, 2), first);
  EXPECT_EQ(first.innovation_products, 0);
  correlation.add(test::pointers(pixels), report(3, -1), second);
  EXPECT_DOUBLE_EQ(second.innovation_products, 1 * 3 - 2 * 1);
  EXPECT_DOUBLE_EQ(second.innovation_squares, (1 + 9) / 2. + (4 + 1) / 2.);
  UpdateReport rejected = report(5, 5);
  rejected.accepted = {false, false};
  correlation.add(test::pointers(pixels), rejected, third);
  EXPECT_EQ(third.innovation_squares, 0);
}

TEST(CloneWindow, EveryNthFrameAndEachIntervalBecomesAClone) {
  test::Random random(1);
  SlamContext x = test::some_context(random);
  x.settings.frames_per_clone = 3;
  x.settings.clone_interval = 1;
  CloneWindow clones;
  const auto augmented = [&](double seconds, bool standstill = false, bool blind = false) {
    ++x.frame;
    FeatureFrame frame{.time = from_seconds(seconds)};
    if (!blind) frame.pixels.push_back({.landmark = 1});
    clones.augment(x, frame, standstill);
    return clones.augmented();
  };
  EXPECT_TRUE(augmented(10));
  const int first = x.frame;
  EXPECT_FALSE(augmented(10.1));
  EXPECT_FALSE(augmented(10.2, false, true)) << "no observation, no count";
  EXPECT_FALSE(augmented(10.3));
  EXPECT_TRUE(augmented(10.4));
  EXPECT_FALSE(augmented(10.5));
  EXPECT_TRUE(augmented(11.5)) << "after the interval";
  EXPECT_FALSE(augmented(12.5, true)) << "during a standstill";
  EXPECT_EQ(clones.oldest(), first);
  EXPECT_EQ(x.state().clones.back().id, x.frame - 1);
}

TEST(CloneWindow, UnusedClonesLeave) {
  test::Random random(2);
  SlamContext x = test::some_context(random);
  x.keep_pose(x.now);
  x.keep_pose(x.now);  // once per frame
  ++x.frame;
  x.keep_pose(x.now);
  ASSERT_EQ(x.state().clones.size(), 5u);
  CloneWindow clones;
  Reused<WaitingTrack> tracks;
  tracks.append().views = {{.clone = 4}};
  clones.remove_unused(x, tracks, std::nullopt);
  ASSERT_EQ(x.state().clones.size(), 4u) << "0, 1, 2 are anchors, 4 has a view";
  clones.remove_unused(x, {}, 4);
  EXPECT_EQ(x.state().clones.size(), 4u);
  clones.remove_unused(x, {}, std::nullopt);
  EXPECT_EQ(x.state().clones.size(), 3u);
}

TEST(UndelayedInitialiser, BeginsLandmarksAtTheirDepthWhileThereIsRoom) {
  test::Random random(3);
  SlamContext x = test::some_context(random);
  x.settings.landmarks = LandmarkForm::kCartesian;
  x.settings.max_landmarks = static_cast<int>(x.state().landmarks.size()) + 2;
  const std::vector<PixelObservation> pixels{{.landmark = 1, .camera = 0, .pixel = {300, 200}},
                                             {.landmark = 1, .camera = 1, .pixel = {310, 200}},
                                             {.landmark = 2, .camera = 0, .pixel = {200, 100}},
                                             {.landmark = 3, .camera = 0, .pixel = {100, 100}}};
  EXPECT_EQ(UndelayedInitialiser(DepthRule{}).initialise(x, test::pointers(pixels)), 2);
  const State& now = x.state();
  EXPECT_EQ(now.landmarks.back().id, 2);
  const Eigen::Vector3d p_imu = now.world_T_imu.inverse() * now.landmarks.back().p_world;
  EXPECT_NEAR((x.camera(0).cam_T_imu * p_imu).z(), x.settings.fixed_depth, 1e-9);
  const UndelayedInitialiser waiting([](const FirstObservation&) { return std::nullopt; });
  EXPECT_FALSE(waiting.landmark(x, 9, 0, {300, 200}, false).has_value());
}

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
