#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/filter/charts/error_chart.hpp>
#include <chasles/lab/monte_carlo.hpp>
#include <chasles/lab/trial.hpp>
#include <chasles/sim/inertial_sim.hpp>

// The inertial filter on simulated scenes: its errors, and its consistency.

namespace chasles {
namespace {

FilterVariant ours() { return {.name = "default", .settings = {}}; }

// For scenes whose tracks have an error that is not white.
FilterVariant white() {
  FilterVariant filter = ours();
  filter.name = "white";
  return filter;
}

// Kleinert & Stilla's filter: Cartesian landmarks at a fixed depth, the world's attitude in the
// state.
FilterVariant paper(const std::string& chart) {
  FilterVariant filter{.name = "paper " + chart, .settings = {}};
  filter.settings.chart = chart;
  filter.settings.landmarks = LandmarkForm::kCartesian;
  filter.settings.init = LandmarkInit::kFixedDepth;
  filter.settings.nav_attitude = true;
  filter.settings.gate = 1;
  return filter;
}

InertialScene short_hallway() {
  InertialScene scene = inertial_scene("hallway");
  scene.settings.hall_length = 12;
  scene.settings.hall_width = 8;
  scene.settings.sections = 2;
  return scene;
}

Trial trial_of(const FilterVariant& filter, const InertialScene& scene, std::uint64_t run = 0) {
  const Recording recording = simulate_inertial(scene, run);
  return run_trial(filter, recording, draw_start(recording, filter.settings, 1, run));
}

std::vector<FilterSummary> study(const InertialScene& scene,
                                 const std::vector<FilterVariant>& filters, std::uint64_t runs) {
  MonteCarloPlan plan{.scene = scene, .filters = filters, .runs = {}};
  for (std::uint64_t run = 0; run < runs; ++run) plan.runs.push_back(run);
  std::vector<TrialRecord> records;
  run_monte_carlo(plan, 2, [&](std::span<const TrialRecord> of_run) {
    records.insert(records.end(), of_run.begin(), of_run.end());
  });
  return summarize(filters, records);
}

TEST(InertialSlam, IsConsistentOnTheTurntable) {
  const FilterSummary s = study(inertial_scene("turntable"), {ours()}, 20).front();
  EXPECT_EQ(s.diverged, 0U);
  EXPECT_GT(s.nees_per_dof, 0.8);
  EXPECT_LT(s.nees_per_dof, 1.15);
  EXPECT_LT(s.mean.position_error, 0.05);
  EXPECT_NEAR(s.mean.nis_per_dof, 1, 0.03);
}

TEST(InertialSlam, IsConsistentInTheHallwayWhereThePapersFiltersAreNot) {
  std::vector<FilterVariant> filters{ours(), paper("standard"), paper("left-se3"),
                                     paper("right-se3")};
  const auto s = study(inertial_scene("hallway"), filters, 6);
  EXPECT_LT(s[0].nees_per_dof, 1.3);
  EXPECT_LT(s[0].mean.position_error, 0.2);
  for (std::size_t i = 1; i < s.size(); ++i) {
    EXPECT_GT(s[i].nees_per_dof, 4) << s[i].filter;  // known to be overconfident
    EXPECT_GT(s[i].mean.position_error, 2 * s[0].mean.position_error) << s[i].filter;
    EXPECT_NEAR(s[i].median.nees_pose, s[1].median.nees_pose, 0.2 * s[1].median.nees_pose);
  }
}

// Tracks that slide, as those of images do, with and without a model of it. The simulated walk is
// that of the pixel, at any distance; the filter's is that of the point. Its NIS is therefore a
// little low as the points come closer.
TEST(InertialSlam, IsConsistentWithTracksThatDriftIfItKnowsTheirDrift) {
  InertialScene scene = inertial_scene("hallway");
  scene.settings.pixel_sigma = 0.4;
  scene.settings.track_drift = 1.5;
  FilterVariant knows = ours();
  knows.settings.track_drift = scene.settings.track_drift;
  const auto s = study(scene, {knows, white()}, 6);
  EXPECT_LT(s[0].nees_per_dof, 2.1);
  EXPECT_GT(s[0].mean.nis_per_dof, 0.75);
  EXPECT_LT(s[0].mean.nis_per_dof, 1.05);
  EXPECT_GT(s[1].nees_per_dof, 4 * s[0].nees_per_dof);
  EXPECT_GT(s[1].mean.position_error, 1.2 * s[0].mean.position_error);
}

// The second camera's matches, off by the same in every frame.
TEST(InertialSlam, CountsTheMatchesOfAPointOnce) {
  double information = 0;
  for (int n = 1; n <= 1000; ++n) information += 1 / TrackNoise{.match = 0.5}.match_variance(n);
  EXPECT_NEAR(information, 1 / 0.25, 0.01);

  InertialScene scene = short_hallway();
  scene.settings.cameras = 2;
  scene.settings.pixel_sigma = 0.2;
  scene.settings.match_sigma = 0.5;
  FilterVariant knows = ours();
  knows.settings.match_sigma = scene.settings.match_sigma;
  const auto s = study(scene, {knows, white()}, 6);
  EXPECT_LT(s[0].nees_per_dof, 2);
  EXPECT_GT(s[1].nees_per_dof, 4 * s[0].nees_per_dof);
  EXPECT_GT(s[1].mean.position_error, s[0].mean.position_error);
}

TEST(InertialSlam, StaysConsistentInTheHallwayWhereTheScaleIsKept) {
  FilterVariant kept = ours();
  kept.settings.keep_scale = Toggle::kTrue;
  const auto s = study(inertial_scene("hallway"), {kept}, 6);
  EXPECT_LT(s[0].nees_per_dof, 1.3);
  EXPECT_LT(s[0].mean.position_error, 0.2);
}

// Tracks alone, none of which enters the state (as Mourikis & Roumeliotis 2007).
TEST(InertialSlam, NeedsNoLandmarkInTheState) {
  FilterVariant tracks = ours();
  tracks.settings.max_landmarks = tracks.settings.min_landmarks = 0;
  const auto s = study(inertial_scene("hallway"), {tracks}, 6);
  EXPECT_EQ(s[0].diverged, 0);
  EXPECT_LT(s[0].mean.position_error, 0.3);
  EXPECT_LT(s[0].nees_per_dof, 1.5);
}

TEST(InertialSlam, FirstEstimatesMakeTheStandardChartConsistent) {
  FilterVariant now = ours();
  now.settings.chart = "standard";
  FilterVariant first = now;
  first.name = "first estimates";
  first.settings.first_estimates = Toggle::kTrue;
  const auto s = study(inertial_scene("hallway"), {now, first}, 8);
  EXPECT_GT(s[0].mean.nees_attitude, 1.4 * s[1].mean.nees_attitude);
  EXPECT_LT(s[1].nees_per_dof, 1.3);
}

// Kleinert & Stilla's numeric Jacobians and their I + F tau, in their charts.
TEST(InertialSlam, ThePapersDerivativesAndTransitionChangeTheEstimateALittle) {
  InertialScene scene = inertial_scene("turntable");
  scene.settings.revolutions = 0.4;
  const auto difference = [](const Trial& a, const Trial& b) {
    EXPECT_EQ(a.estimate.size(), b.estimate.size());
    return (a.estimate.back().pose.p - b.estimate.back().pose.p).norm();
  };
  for (const char* chart : {"standard", "left-se3", "right-se3"}) {
    SCOPED_TRACE(chart);
    FilterVariant numeric = paper(chart), first_order = paper(chart);
    numeric.settings.numeric_jacobians = true;
    first_order.settings.first_order_transition = true;
    const Trial exact = trial_of(paper(chart), scene);
    EXPECT_GT(difference(exact, trial_of(numeric, scene)), 0);
    EXPECT_LT(difference(exact, trial_of(numeric, scene)), 1e-4);
    EXPECT_GT(difference(exact, trial_of(first_order, scene)), 1e-5);
    EXPECT_LT(difference(exact, trial_of(first_order, scene)), 0.01);
  }
}

TEST(InertialSlam, WithNextToNoNoiseThereIsNextToNoError) {
  InertialScene scene = short_hallway();
  auto& s = scene.settings;
  s.imu_convention = ImuConvention::kIntervalMean;
  s.imu_rate = 280;  // a frame at every tenth sample: no sample is cut in two
  s.pixel_sigma = 1e-4;
  s.accelerometer_noise_density = s.gyroscope_noise_density = 1e-7;
  s.accelerometer_random_walk = s.gyroscope_random_walk = 1e-9;
  s.accelerometer_bias_sigma = s.gyroscope_bias_sigma = 1e-7;
  for (const ErrorChart& chart : error_charts()) {
    FilterVariant filter = ours();
    filter.settings.chart = chart.name;
    filter.settings.initial_tilt_sigma = filter.settings.initial_velocity_sigma = 1e-7;
    filter.settings.initial_accelerometer_bias_sigma = 1e-7;
    filter.settings.initial_gyroscope_bias_sigma = 1e-7;
    filter.settings.gate = 1;
    const TrialAverages a = averages(trial_of(filter, scene));
    EXPECT_LT(a.position_error, 5e-4) << chart.name;
    EXPECT_LT(a.attitude_error, 1e-5) << chart.name;
  }
}

TEST(InertialSlam, EveryChartFormAndBeginningRunsWithOneAndTwoCameras) {
  for (const ErrorChart& chart : error_charts()) {
    for (const LandmarkForm form : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
      for (const LandmarkInit init : {LandmarkInit::kMultiView, LandmarkInit::kFixedDepth}) {
        for (const bool nav : {false, true}) {
          InertialScene scene = short_hallway();
          scene.settings.sections = 1;
          scene.settings.cameras = nav ? 2 : 1;
          FilterVariant filter = ours();
          filter.settings.chart = chart.name;
          filter.settings.landmarks = form;
          filter.settings.init = init;
          filter.settings.nav_attitude = nav;
          const Trial trial = trial_of(filter, scene);
          EXPECT_FALSE(trial.diverged);
          EXPECT_LT(trial.points.back().position_error, 1.5)
              << chart.name << " " << name_of(form) << " " << name_of(init) << " nav " << nav;
        }
      }
    }
  }
}

TEST(InertialSlam, CompositionChangesNothingThatIsSeen) {
  FilterVariant plain = ours();
  plain.settings.chart = "standard";
  plain.settings.nav_attitude = true;
  FilterVariant composed = plain;
  composed.settings.composition_interval = 0.5;
  const Trial a = trial_of(plain, short_hallway());
  const Trial b = trial_of(composed, short_hallway());
  ASSERT_EQ(a.points.size(), b.points.size());
  // Until the first composition they are equal; later the two have different linearisation points.
  EXPECT_LT((a.estimate[12].pose.p - b.estimate[12].pose.p).norm(), 1e-12);
  EXPECT_LT((a.estimate[20].pose.p - b.estimate[20].pose.p).norm(), 2e-3);
  EXPECT_NEAR(averages(a).position_error, averages(b).position_error, 0.1);
  plain.settings.nav_attitude = false;
  plain.settings.composition_interval = 1;
  EXPECT_THROW(trial_of(plain, short_hallway()), UsageError);
}

TEST(InertialSlam, OutliersAndDroppedFramesAreSurvived) {
  InertialScene scene = short_hallway();
  scene.settings.outlier_fraction = 0.05;
  scene.settings.dropped_fraction = 0.1;
  FilterVariant filter = ours();
  filter.settings.waiting_frames = 3;
  const Trial trial = trial_of(filter, scene);
  EXPECT_FALSE(trial.diverged);
  EXPECT_LT(averages(trial).position_error, 0.3);
}

TEST(InertialSlam, AnOutageIsPredictedOverWithAConsistentCovarianceAndRecoveredFrom) {
  Recording recording = simulate_inertial(short_hallway(), 0);
  const Time from = recording.frames.front().time + from_seconds(5);
  for (FeatureFrame& frame : recording.frames) {
    if (frame.time > from && frame.time < from + from_seconds(1.5)) frame.pixels.clear();
  }
  const FilterVariant filter = ours();
  const Trial trial = run_trial(filter, recording, draw_start(recording, filter.settings, 1, 0));
  EXPECT_FALSE(trial.diverged);
  EXPECT_LT(trial.points.back().position_error, 1);
  EXPECT_LT(averages(trial).nees_pose, 18);
}

TEST(InertialSlam, SamplesThatAreMissingOrNotFiniteAreBridged) {
  Recording recording = simulate_inertial(short_hallway(), 0);
  recording.imu[300].angular_rate_imu.x() = std::numeric_limits<double>::quiet_NaN();
  recording.imu.erase(recording.imu.begin() + 500, recording.imu.begin() + 508);
  const FilterVariant filter = ours();
  const Trial trial = run_trial(filter, recording, draw_start(recording, filter.settings, 1, 0));
  EXPECT_FALSE(trial.diverged);
  EXPECT_LT(averages(trial).position_error, 0.3);
}

TEST(InertialSlam, WhatCannotBeUsedIsRejectedOrLeftOut) {
  const Recording recording = simulate_inertial(short_hallway(), 0);
  const FilterVariant filter = ours();
  const InertialStart start = draw_start(recording, filter.settings, 1, 0);
  InertialSlam slam(filter.settings, recording.cameras, *recording.imu_noise, {}, 1, start);
  FeatureFrame frame{.time = start.time + from_seconds(0.1)};
  EXPECT_THROW(slam.process(frame), InputError);  // no IMU sample
  for (const ImuSample& sample : recording.imu) slam.process(sample);
  frame.pixels = {{.landmark = 1, .camera = 7, .pixel = {10, 10}},
                  {.landmark = 2, .camera = 0, .pixel = {std::nan(""), 10}},
                  {.landmark = 3, .camera = 0, .pixel = {300, 200}},
                  {.landmark = 3, .camera = 0, .pixel = {301, 200}}};
  const Estimate e = slam.process(frame);
  EXPECT_EQ(e.observations, 4);
  EXPECT_EQ(e.added, 1);
  frame.time = start.time;
  EXPECT_THROW(slam.process(frame), InputError);  // backwards
}

TEST(InertialSlam, TwoRunsGiveTheSameNumbers) {
  const Trial a = trial_of(ours(), short_hallway());
  const Trial b = trial_of(ours(), short_hallway());
  ASSERT_EQ(a.points.size(), b.points.size());
  EXPECT_EQ(a.estimate.back().pose.p, b.estimate.back().pose.p);
  EXPECT_EQ(a.points.back().nees_pose, b.points.back().nees_pose);
}

}  // namespace
}  // namespace chasles
