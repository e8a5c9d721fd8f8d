#include <memory>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/pipeline/observer_list.hpp>
#include <chasles/pipeline/recording_sensors.hpp>
#include <chasles/session/run_recorder.hpp>
#include <chasles/sim/street.hpp>

// What is recorded of a run, against what another observer of the same run gets.
namespace chasles {
namespace {

const Recording& recorded_street() {
  static const Recording recording = simulate_street({.route = "LS", .features_per_frame = 20});
  return recording;
}

std::unique_ptr<Estimator> filter() {
  return make_estimator(VelocityRunSettings{}, recorded_street());
}

struct SeenFrames : RunObserver {
  bool stop() override { return frames.size() == limit; }
  void on_frame(const FeatureFrame& frame) override { frames.push_back(frame); }
  void on_estimate(const Estimate& e, const EstimateTiming&) override { estimates.push_back(e); }
  std::size_t limit = 1'000'000;
  std::vector<FeatureFrame> frames;
  std::vector<Estimate> estimates;
};

RecordedRun record(SeenFrames& seen) {
  const auto estimator = filter();
  RunRecorder recorder(recorded_street(), *estimator, {});
  ObserverList observers{recorder, seen};
  return recorder.finish(run(recorded_street(), *estimator, {}, {}, observers));
}

TEST(RunRecorder, HasAStateForEachEstimate) {
  SeenFrames seen;
  const RecordedRun recorded = record(seen);
  ASSERT_EQ(recorded.run.states.size(), seen.estimates.size());
  for (std::size_t i = 0; i < seen.estimates.size(); ++i) {
    EXPECT_EQ(recorded.run.states[i].time, seen.estimates[i].time);
    EXPECT_EQ(recorded.run.states[i].world_T_imu.p, seen.estimates[i].world_T_imu.p);
  }
  EXPECT_EQ(recorded.coverage.frames, seen.frames.size());
  EXPECT_EQ(recorded.coverage.estimated, seen.frames.size());
}

TEST(RunRecorder, ALandmarkHasTheTimesOfItsObservations) {
  SeenFrames seen;
  const RecordedRun recorded = record(seen);
  ASSERT_FALSE(recorded.run.landmarks.empty());
  const RunLandmark& landmark = recorded.run.landmarks.front();
  std::vector<Time> times;
  for (const FeatureFrame& frame : seen.frames) {
    for (const StereoObservation& o : frame.observations) {
      if (o.landmark == landmark.id) times.push_back(frame.time);
    }
  }
  ASSERT_FALSE(times.empty());
  EXPECT_EQ(landmark.first_seen, times.front());
  EXPECT_EQ(landmark.last_seen, times.back());
}

TEST(RunRecorder, OfAnInterruptedRunTheFramesThatCameCount) {
  SeenFrames seen;
  seen.limit = 7;
  const RecordedRun recorded = record(seen);
  EXPECT_TRUE(recorded.report.interrupted);
  EXPECT_EQ(recorded.coverage.frames, 7u);
  EXPECT_LT(recorded.coverage.frames, frame_count(recorded_street()));
}

FeatureFrame frame_at(Time time) {
  FeatureFrame frame;
  frame.time = time;
  return frame;
}

Estimate estimate_at(Time time) {
  Estimate e;
  e.time = time;
  e.covariance = Matrix6d::Identity();
  return e;
}

TEST(RunRecorder, TheStartCountsFromTheFirstFrame) {
  using std::chrono::seconds;
  const auto estimator = filter();
  RunRecorder recorder(recorded_street(), *estimator, {});
  for (const int second : {10, 11, 13}) recorder.on_frame(frame_at(seconds(second)));
  recorder.on_estimate(estimate_at(seconds(11)), {});
  recorder.on_estimate(estimate_at(seconds(13)), {});
  EXPECT_EQ(recorder.recorded_seconds(seconds(13)), 3);
  const RecordedRun recorded = recorder.finish({});
  EXPECT_EQ(recorded.start_seconds, 1);
  EXPECT_EQ(recorded.initialised_seconds, 3);
  EXPECT_EQ(recorded.coverage.before_start, 2u);
}

TEST(RunRecorder, BatchEstimationReplacesTheStatesAndWhatIsCountedOfThem) {
  using std::chrono::seconds;
  const auto estimator = filter();
  RunRecorder recorder(recorded_street(), *estimator, {.has_stages = true});
  recorder.on_frame(frame_at(seconds(1)));
  Estimate degraded = estimate_at(seconds(1));
  degraded.health = Health::kDegraded;
  degraded.degradation = Degradation::kLens;
  degraded.scale_sigma = 0.01;
  recorder.on_estimate(degraded, {});
  const std::vector<Estimate> smoothed = {estimate_at(seconds(1)), estimate_at(seconds(2))};
  recorder.on_smoothed(smoothed, 0.5);
  const RecordedRun recorded = recorder.finish({});
  ASSERT_EQ(recorded.run.states.size(), 2u);
  EXPECT_EQ(recorded.run.states[1].time, seconds(2));
  EXPECT_EQ(recorded.run.states[1].milliseconds, 250);
  EXPECT_TRUE(recorded.run.stage_names.empty());
  EXPECT_TRUE(recorded.degradations.empty());
  EXPECT_FALSE(recorded.scale_sigma);
}

}  // namespace
}  // namespace chasles
