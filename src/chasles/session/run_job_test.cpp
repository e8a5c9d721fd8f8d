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

struct CountingObserver : SessionObserver {
  void begin(const Run& header, const nlohmann::ordered_json& known,
             const Recording& recording) override {
    ++starts;
    named = header.name == recording.name && known.contains("settings");
  }
  void on_frame(const FeatureFrame&) override { ++frames; }
  void advance(const Run& run, std::size_t done, double,
               const std::function<LiveMap()>& map) override {
    grows = grows && run.states.size() >= states && done == frames;
    states = run.states.size();
    if (done == 5) landmarks = map().landmarks.size();
  }
  int starts = 0;
  bool named = false, grows = true;
  std::size_t frames = 0, states = 0, landmarks = 0;
};

SessionOptions quiet() {
  SessionOptions options;
  options.quiet = true;
  return options;
}

TEST(RunJob, ItsObserverFollowsEachFrame) {
  Recording recording = short_street();
  const SessionOptions options = quiet();
  CountingObserver observer;
  const CompletedRun run = plan_run(options, recording)([] { return false; }, observer);
  EXPECT_EQ(observer.starts, 1);
  EXPECT_TRUE(observer.named);
  EXPECT_TRUE(observer.grows);
  EXPECT_EQ(observer.frames, frame_count(recording));
  EXPECT_EQ(observer.states, run.result.run.states.size());
  EXPECT_GT(observer.landmarks, 0u);
}

TEST(RunJob, EndsWhereItIsAskedTo) {
  Recording recording = short_street();
  const SessionOptions options = quiet();
  CountingObserver observer;
  const CompletedRun run =
      plan_run(options, recording)([&] { return observer.frames >= 7; }, observer);
  EXPECT_EQ(run.result.run.states.size(), 7u);
  EXPECT_TRUE(run.summary.at("interrupted"));
}

TEST(RunJob, TakesItsSettingsFromAFile) {
  const fs::path file = fs::path(testing::TempDir()) / "chasles_run_job_settings.yaml";
  std::ofstream(file) << "chart: standard\n";
  Recording recording = short_street();
  SessionOptions options = quiet();
  options.settings.config = file.string();
  SessionObserver nobody;
  const CompletedRun run = plan_run(options, recording)([] { return false; }, nobody);
  EXPECT_EQ(run.summary.at("chart"), "standard");
  std::ofstream(file) << "charts: standard\n";
  EXPECT_THROW(plan_run(options, recording), UsageError);
  fs::remove(file);
}

}  // namespace
}  // namespace chasles
