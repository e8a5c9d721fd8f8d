#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/check/velocity_clock.hpp>
#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/pipeline/run.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/street.hpp>
#include <chasles/slam/inertial_session_testing.hpp>
#include <chasles/velocity/velocity_slam.hpp>

// Filter, window and batch through one interface, on simulated recordings of both kinds.
namespace chasles {
namespace {

using test::error_from;

Recording halls(int sections, double length) {
  InertialScene scene = inertial_scene("hallway");
  scene.settings.hall_length = length;
  scene.settings.sections = sections;
  scene.settings.rest_duration = 1.5;
  return simulate_inertial(scene);
}

const Recording& hallway() {
  static const Recording recording = halls(1, 8);
  return recording;
}

const Recording& walk_of_two_halls() {
  static const Recording recording = halls(2, 10);
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

TEST(RunOfARollingShutter, NeedsAReadoutWithinTheTimeOfAFrame) {
  Recording recording = hallway();
  recording.cameras.front().shutter.readout = 0.05;
  std::string message;
  try {
    run(recording, inertial("filter"));
  } catch (const InputError& error) {
    message = error.what();
  }
  for (const char* part : {"cam0 has a readout_time of 50.0 ms", "35.7 ms between its images"}) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
  }
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

TEST(Run, SettingsOfTheOtherKindSayWhatToCall) {
  try {
    chasles::run(street(), inertial("filter"));
    FAIL() << "a drive has no camera with an IMU";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("VelocityRunSettings"), std::string::npos)
        << error.what();
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
  EXPECT_EQ(run.landmarks.size(), slam.filter().past().map().size());
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

TEST(Run, ItsObserverHearsNothingMoreAfterTheRun) {
  Recording shorter = hallway();
  const FeatureFrame last = shorter.frames.back();
  shorter.frames.pop_back();
  Counter counter;
  const auto estimator = make_estimator(inertial("filter"), shorter);
  run(shorter, *estimator, {}, {}, counter);
  const std::size_t outcomes = counter.outcomes;
  EXPECT_GT(outcomes, 0u);
  EXPECT_EQ(estimator->process(last).size(), 1u);
  EXPECT_EQ(counter.outcomes, outcomes);
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

TEST(Run, AStopDuringBatchEstimationLeavesTheFiltersResult) {
  class StopsInSmoothing : public Counter {
   public:
    bool stop() override { return smoothings > 0 && ++polls > 2; }
    int polls = 0;
  };
  const auto check = [](const Recording& recording, Estimator& estimator) {
    StopsInSmoothing observer;
    const RunReport report = run(recording, estimator, {}, {}, observer);
    EXPECT_TRUE(report.interrupted);
    EXPECT_TRUE(report.in_smoothing);
    EXPECT_EQ(observer.frames, recording.frames.size());
    EXPECT_EQ(observer.smoothed, 0u);
    EXPECT_FALSE(report.estimator.batch);
    EXPECT_GT(estimator.map().size(), 20u) << "the filter's";
    EXPECT_LT(observer.polls, 6) << "it goes on after the stop";
  };
  check(hallway(), *make_estimator(inertial("batch"), hallway()));
  check(street(), *make_estimator(velocity("batch"), velocity_sensors(street(), {})));
}

TEST(Run, OnlyTheStereoVelocityFilterHasAJointCovarianceOfItsMap) {
  for (const char* kind : {"filter", "window:5", "batch"}) {
    const auto of_street = make_estimator(velocity(kind), velocity_sensors(street(), {}));
    EXPECT_EQ(filter_with_joint_map(*of_street) != nullptr, std::string(kind) == "filter") << kind;
    const auto of_hallway = make_estimator(inertial(kind), hallway());
    EXPECT_EQ(filter_with_joint_map(*of_hallway), nullptr) << kind;
  }
}

// A recording that pauses: samples and frames between the times are missing, and all later ones
// come so much later.
Recording pausing(double from, double to, double later) {
  Recording recording = walk_of_two_halls();
  const Time begin = recording.frames.front().time;
  const auto edit = [&](auto& events) {
    std::erase_if(events, [&](const auto& event) {
      const double at = to_seconds(event.time - begin);
      return at > from && at < to;
    });
    for (auto& event : events) {
      if (to_seconds(event.time - begin) >= to) event.time += from_seconds(later);
    }
  };
  edit(recording.imu);
  edit(recording.frames);
  for (StampedPose& pose : recording.truth) {
    if (to_seconds(pose.time - begin) >= to) pose.time += from_seconds(later);
  }
  return recording;
}

// Estimates before a time, or from it on.
std::vector<Estimate> side(const std::vector<Estimate>& all, Time middle, bool after) {
  std::vector<Estimate> some;
  std::ranges::copy_if(all, std::back_inserter(some),
                       [&](const Estimate& e) { return (e.time > middle) == after; });
  return some;
}

TEST(Run, APauseOfTheDataEndsAPartAndNotTheRun) {
  constexpr double kFrom = 8, kTo = 8.7;
  for (const double later : {0.0, 86400.0}) {
    const Recording recording = pausing(kFrom, kTo, later);
    const Time middle = recording.frames.front().time + from_seconds(kFrom + 0.3);
    for (const char* estimator : {"filter", "window:5", "batch"}) {
      SCOPED_TRACE(::testing::Message() << estimator << ", " << later << " s");
      const RunResult run = chasles::run(recording, inertial(estimator));
      expect_complete(run);
      for (const bool after : {false, true}) {
        const std::vector<Estimate> part = side(run.estimates, middle, after);
        ASSERT_GT(part.size(), 40u) << after;
        EXPECT_LT(error_from(part, recording), 0.15) << after;
      }
      const EstimatorReport& report = run.report.estimator;
      EXPECT_EQ(report.resets, 1);
      EXPECT_EQ(report.batch ? report.batch->parts : 2, 2);
      // The way in the pause is unknown, and the covariance says so.
      const std::vector<Estimate> last = side(run.estimates, middle, true);
      EXPECT_GT(std::sqrt(last.front().pose_covariance().diagonal().tail<3>().sum()),
                0.5 * std::min(later + kTo - kFrom, 500.0));
      EXPECT_TRUE(std::ranges::is_sorted(run.estimates, {}, &Estimate::time));
    }
  }
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

template <typename Work>
std::string rejection(const Work& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was rejected";
}

void expect_rejected(const std::string& words, const std::function<void()>& work) {
  const std::string text = rejection(work);
  EXPECT_NE(text.find(words), std::string::npos) << text;
}

TEST(Run, WhatARecordingLacksIsNamed) {
  expect_rejected("no IMU samples with cameras",
                  [] { chasles::run(street(), InertialRunSettings{}); });
  expect_rejected("0 body velocities", [] { chasles::run(hallway(), VelocityRunSettings{}); });
  Recording silent = hallway();
  silent.imu_noise.reset();
  expect_rejected("states no IMU noise", [&] { chasles::run(silent, InertialRunSettings{}); });
}

// Before the run, not after the filter has gone through the recording.
TEST(Run, SettingsThatCannotBeUsedAreRejectedFirst) {
  const auto rejected = [](const std::string& words, const auto& settings, const auto& sensors) {
    expect_rejected(words, [&] { make_estimator(settings, sensors); });
  };
  const InertialSensors imu = inertial_sensors(hallway());
  InertialRunSettings wrong = inertial("window:5");
  wrong.estimator.keyframes = 1;
  rejected("window of 1 keyframes", wrong, imu);
  wrong = inertial("batch");
  wrong.batch.max_iterations = 0;
  rejected("batch.max_iterations: found 0", wrong, imu);
  wrong = inertial("filter");
  wrong.frontend.window = 14;
  rejected("frontend.window: found 14", wrong, imu);
  const VelocitySensors stereo = velocity_sensors(street(), {});
  VelocityRunSettings other = velocity("batch");
  other.filter.mode = SlamMode::kMap;
  rejected("--mode slam", other, stereo);
  other = velocity("window:5");
  other.filter.initial_landmark_sigma = 0.1;
  rejected("initial_landmark_sigma", other, stereo);
}

TEST(CorrectClock, ShiftsByTheStatedOffsetOrTheEstimatedOne) {
  Recording recording = street();
  const Time before = recording.velocities[7].time;
  VelocitySlamSettings settings;
  settings.time_offset = 0.05;
  const ClockCorrection stated = correct_clock(settings, recording);
  EXPECT_EQ(stated.offset, 0.05);
  EXPECT_TRUE(stated.remark.empty());
  EXPECT_EQ(recording.velocities[7].time, before - from_seconds(0.05));
  // Estimated as check/velocity_clock.hpp does.
  StreetSettings scene = street_scene("street-ins");
  scene.route = "RL";
  scene.block_length = scene.block_width = 60;
  Recording late = simulate_street(scene);
  for (BodyVelocity& velocity : late.velocities) velocity.time += from_seconds(0.06);
  const auto clock = velocity_clock(late);
  ASSERT_TRUE(clock && clock->stands_out());
  settings.time_offset.reset();
  const ClockCorrection estimated = correct_clock(settings, late);
  EXPECT_EQ(estimated.offset, clock->offset);
  EXPECT_NEAR(estimated.offset, 0.06, 4 * clock->sigma);
  EXPECT_NE(estimated.remark.find("are corrected"), std::string::npos) << estimated.remark;
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
