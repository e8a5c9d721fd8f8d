#include <cstddef>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/session/run_job.hpp>
#include <chasles/sim/street.hpp>

// A run as a program without a command line has it.
namespace chasles {
namespace {

namespace fs = std::filesystem;

const Recording& short_street() {
  static const Recording recording = simulate_street({.route = "LS", .features_per_frame = 20});
  return recording;
}

// What a viewer finds in the recorder at each of its calls.
struct CountingViewer : RunObserver {
  explicit CountingViewer(const RunRecorder& of) : recorder(of) {}
  void on_frame(const FeatureFrame&) override { ++frames; }
  void on_progress(std::size_t done, Time now) override {
    grows = grows && recorder.run().states.size() >= states && done == frames &&
            recorder.recorded_seconds(now) >= seconds;
    states = recorder.run().states.size();
    seconds = recorder.recorded_seconds(now);
    if (done == 5) landmarks = recorder.live_map().landmarks.size();
  }
  const RunRecorder& recorder;
  bool grows = true;
  double seconds = 0;
  std::size_t frames = 0, states = 0, landmarks = 0;
};

SessionOptions quiet() {
  SessionOptions options;
  options.quiet = true;
  return options;
}

bool goes_on() { return false; }

TEST(RunJob, AViewerBeginsWithTheHeaderAndFollowsEachFrame) {
  Recording recording = short_street();
  const SessionOptions options = quiet();
  PreparedRun prepared = plan_run(options, recording)(goes_on);
  const chasles::Run header = prepared.recorder().header();
  EXPECT_EQ(header.name, recording.name);
  EXPECT_TRUE(header.states.empty());
  EXPECT_EQ(header.truth.size(), recording.truth.size());
  EXPECT_TRUE(prepared.known().contains("settings"));
  CountingViewer viewer(prepared.recorder());
  const CompletedRun run = prepared.run(viewer);
  EXPECT_TRUE(viewer.grows);
  EXPECT_EQ(viewer.frames, frame_count(recording));
  EXPECT_EQ(viewer.states, run.result.run.states.size());
  EXPECT_GT(viewer.landmarks, 0u);
}

TEST(RunJob, ATruthWhoseClockIsNotKnownYetIsInTheResultAlone) {
  Recording recording = short_street();
  SessionOptions options = quiet();
  options.input.truth_options.time_offset = "auto";
  PreparedRun prepared = plan_run(options, recording)(goes_on);
  EXPECT_TRUE(prepared.recorder().header().truth.empty());
  RunObserver nobody;
  EXPECT_EQ(prepared.run(nobody).result.run.truth.size(), recording.truth.size());
}

TEST(RunJob, EndsWhereItIsAskedTo) {
  Recording recording = short_street();
  const SessionOptions options = quiet();
  struct : RunObserver {
    void on_frame(const FeatureFrame&) override { ++frames; }
    std::size_t frames = 0;
  } counter;
  PreparedRun prepared = plan_run(options, recording)([&] { return counter.frames >= 7; });
  const CompletedRun run = prepared.run(counter);
  EXPECT_EQ(run.result.run.states.size(), 7u);
  EXPECT_TRUE(run.summary.at("interrupted"));
}

TEST(RunJob, TakesItsSettingsFromAFile) {
  const fs::path file = fs::path(testing::TempDir()) / "chasles_run_job_settings.yaml";
  std::ofstream(file) << "chart: standard\n";
  Recording recording = short_street();
  SessionOptions options = quiet();
  options.settings.config = file.string();
  RunObserver nobody;
  const CompletedRun run = plan_run(options, recording)(goes_on).run(nobody);
  EXPECT_EQ(run.summary.at("chart"), "standard");
  std::ofstream(file) << "charts: standard\n";
  EXPECT_THROW(plan_run(options, recording), UsageError);
  fs::remove(file);
}

}  // namespace
}  // namespace chasles
