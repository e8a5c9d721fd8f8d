#include <algorithm>
#include <functional>

#include <gtest/gtest.h>

#include <chasles/error.hpp>
#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/pipeline/run.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/street.hpp>
#include <chasles/slam/inertial_session_testing.hpp>
#include <chasles/slam/velocity_slam.hpp>

// Filter, window and batch through one interface, on simulated recordings of both kinds.
namespace chasles {
namespace {

using test::error_from;

const Recording& hallway() {
  static const Recording recording = [] {
    InertialScene scene = inertial_scene("hallway");
    scene.settings.hall_length = 8;
    scene.settings.sections = 1;
    scene.settings.rest_duration = 1.5;
    return simulate_inertial(scene);
  }();
  return recording;
}

const Recording& street() {
  static const Recording recording = simulate_street({.route = "LS", .features_per_frame = 20});
  return recording;
}

InertialRunSettings inertial(const char* estimator) {
  InertialRunSettings settings;
  settings.estimator = estimator_choice(estimator);
  return settings;
}

VelocityRunSettings velocity(const char* estimator) {
  VelocityRunSettings settings;
  settings.estimator = estimator_choice(estimator);
  return settings;
}

// The numbers of an estimate are those that state_names() names, behind the pose.
void expect_complete(const RunResult& run) {
  ASSERT_FALSE(run.estimates.empty());
  for (const Estimate& e : run.estimates) {
    const Eigen::Index states = (e.v_world ? 3 : 0) + e.additive.size();
    ASSERT_EQ(states, std::ssize(run.state_names));
    ASSERT_EQ(e.covariance.rows(), 6 + states);
    ASSERT_TRUE(e.covariance.allFinite());
    EXPECT_LT((e.covariance - e.covariance.transpose()).norm(), 1e-9 * e.covariance.norm());
    EXPECT_GT(e.additive_sigma().minCoeff(), 0);
  }
  EXPECT_TRUE(std::ranges::is_sorted(run.estimates, {}, &Estimate::time));
  EXPECT_GT(run.landmarks.size(), 20u);
}

TEST(Run, EachEstimatorFollowsAVisualInertialRecording) {
  for (const char* estimator : {"filter", "window:5", "batch"}) {
    SCOPED_TRACE(estimator);
    const RunResult run = chasles::run(hallway(), inertial(estimator));
    expect_complete(run);
    ASSERT_EQ(run.state_names.size(), 9u);
    EXPECT_EQ(run.state_names.front(), "velocity_x");
    EXPECT_LT(error_from(run.estimates, hallway()), 0.1);
    EXPECT_EQ(run.report.estimator.window.has_value(), std::string(estimator) == "window:5");
    EXPECT_EQ(run.report.estimator.batch.has_value(), std::string(estimator) == "batch");
    EXPECT_GT(run.report.estimator.imu.used, 500);
    EXPECT_EQ(run.report.frontend.frames, 0);  // the recording has tracks, not images
  }
}

TEST(Run, EachEstimatorFollowsAStereoVelocityRecording) {
  for (const char* estimator : {"filter", "window:5", "batch"}) {
    SCOPED_TRACE(estimator);
    const RunResult run = chasles::run(street(), velocity(estimator));
    expect_complete(run);
    EXPECT_EQ(run.estimates.size(), street().frames.size());
    EXPECT_FALSE(run.estimates.back().v_world);
    EXPECT_LT((run.estimates.back().world_T_imu.p - street().truth.back().pose.p).norm(), 5);
    EXPECT_EQ(run.report.estimator.window.has_value(), std::string(estimator) == "window:5");
    EXPECT_EQ(run.report.estimator.batch.has_value(), std::string(estimator) == "batch");
  }
}

TEST(Run, TheFilterGivesTheNumbersOfItsOwnLoop) {
  const VelocitySensors sensors = velocity_sensors(street(), {});
  VelocitySlam slam({}, sensors.rig, sensors.noise);
  std::vector<Estimate> own;
  EventStream events(street());
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<BodyVelocity>(&*event)) slam.process(*sample);
    if (const auto* frame = std::get_if<FeatureFrame>(&*event)) own.push_back(slam.process(*frame));
  }
  const RunResult run = chasles::run(street(), VelocityRunSettings{});
  ASSERT_EQ(run.estimates.size(), own.size());
  for (std::size_t i = 0; i < own.size(); ++i) {
    EXPECT_EQ(run.estimates[i].world_T_imu.p, own[i].world_T_imu.p) << i;
    EXPECT_EQ(run.estimates[i].covariance, own[i].covariance) << i;
  }
  EXPECT_EQ(run.landmarks.size(), slam.filter().map().size());
}

// An IMU beside the velocities, velocities beside an IMU.
TEST(Run, EventsOfTheOtherKindChangeNothing) {
  Recording both = street();
  both.imu = hallway().imu;
  const RunResult with = chasles::run(both, VelocityRunSettings{});
  const RunResult without = chasles::run(street(), VelocityRunSettings{});
  EXPECT_EQ(with.estimates.back().world_T_imu.p, without.estimates.back().world_T_imu.p);
  Recording more = hallway();
  more.velocities = street().velocities;
  const RunResult inertial_with = chasles::run(more, InertialRunSettings{});
  const RunResult inertial_without = chasles::run(hallway(), InertialRunSettings{});
  EXPECT_EQ(inertial_with.estimates.back().world_T_imu.p,
            inertial_without.estimates.back().world_T_imu.p);
}

class Counter : public RunObserver {
 public:
  bool stop() override { return frames == limit; }
  void on_frame(const FeatureFrame&) override { ++frames; }
  void on_outcomes(const FeatureFrame&, std::span<const PixelOutcome>) override { ++outcomes; }
  void on_estimate(const Estimate&, const EstimateTiming&) override { ++estimates; }
  void on_progress(std::size_t count, Time) override { progress = count; }
  void on_smoothing() override { ++smoothings; }
  void on_smoothed(std::span<const Estimate> all, double) override { smoothed = all.size(); }

  std::size_t limit = 1'000'000;
  std::size_t frames = 0, outcomes = 0, estimates = 0, progress = 0, smoothings = 0, smoothed = 0;
};

TEST(Run, AnObserverSeesEveryFrameAndEstimate) {
  Counter counter;
  const auto estimator = make_estimator(inertial("batch"), hallway());
  const RunReport report = run(hallway(), *estimator, {}, {}, counter);
  EXPECT_FALSE(report.interrupted);
  EXPECT_EQ(counter.frames, hallway().frames.size());
  EXPECT_EQ(counter.progress, counter.frames);
  EXPECT_EQ(counter.outcomes, counter.estimates);
  EXPECT_GT(counter.estimates, counter.frames / 2);
  EXPECT_EQ(counter.smoothings, 1u);
  EXPECT_EQ(counter.smoothed, static_cast<std::size_t>(report.estimator.batch->keyframes));
}

TEST(Run, AStopEndsItEarlyWithoutBatchEstimation) {
  Counter counter;
  counter.limit = 60;
  const auto estimator = make_estimator(inertial("batch"), hallway());
  const RunReport report = run(hallway(), *estimator, {}, {}, counter);
  EXPECT_TRUE(report.interrupted);
  EXPECT_EQ(counter.frames, 60u);
  EXPECT_EQ(counter.smoothings, 0u);
  EXPECT_FALSE(report.estimator.batch);
}

TEST(Run, ARunThatNeverStartsSaysWhatWasMissing) {
  Recording dark = hallway();
  for (FeatureFrame& frame : dark.frames) frame.pixels.clear();
  dark.imu.resize(100);
  for (const char* estimator : {"filter", "window:5", "batch"}) {
    try {
      chasles::run(dark, inertial(estimator));
      ADD_FAILURE() << estimator << " started";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kNotInitialised);
      EXPECT_NE(std::string(error.what()).find("not initialised after"), std::string::npos)
          << error.what();
    }
  }
}

TEST(Run, WhatARecordingLacksIsNamed) {
  EXPECT_THROW(chasles::run(street(), InertialRunSettings{}), InputError);  // no camera
  Recording silent = hallway();
  silent.imu_noise.reset();
  EXPECT_THROW(chasles::run(silent, InertialRunSettings{}), InputError);
  InertialRunSettings calibrates = inertial("window:5");
  calibrates.filter.calibrate_time_offset = true;
  EXPECT_THROW(chasles::run(hallway(), calibrates), UsageError);
}

TEST(EstimatorChoice, IsReadByName) {
  EXPECT_TRUE(estimator_choice("filter").is_filter());
  EXPECT_TRUE(estimator_choice("batch").is_batch());
  EXPECT_TRUE(estimator_choice("window:12").is_window());
  EXPECT_EQ(estimator_choice("window:12").keyframes, 12);
  for (const char* wrong : {"", "ekf", "window", "window:", "window:1", "window:-3", "window:5x",
                            "window:99999999999", "Filter"}) {
    try {
      estimator_choice(wrong, "--estimator");
      ADD_FAILURE() << wrong << " was accepted";
    } catch (const UsageError& error) {
      EXPECT_EQ(std::string(error.what()).find("--estimator: found '" + std::string(wrong)), 0u);
    }
  }
}

}  // namespace
}  // namespace chasles
