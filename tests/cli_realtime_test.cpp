#include <algorithm>
#include <cmath>
#include <csignal>
#include <fcntl.h>
#include <spawn.h>
#include <vector>

#include <nlohmann/json.hpp>

#include <chasles/run_folder/run.hpp>

#include "cli_test.hpp"
#include "realtime.hpp"

// `chasles run --realtime`. The number of dropped frames depends on the machine and is not tested.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

void simulate_hallway(const Scratch& folder) {
  const Outcome made = chasles(folder, "simulate hallway -o rec --quiet");
  ASSERT_EQ(made.code, 0) << made.err;
}

void expect_rising(const std::vector<RunState>& states) {
  EXPECT_TRUE(std::is_sorted(states.begin(), states.end(),
                             [](const auto& a, const auto& b) { return a.time <= b.time; }));
}

// At 20 times the speed it takes a second. At a million times most frames come while others wait.
TEST(Realtime, EveryFrameIsEstimatedOrDropped) {
  const Scratch folder;
  simulate_hallway(folder);
  for (const char* speed : {"20", "1e6"}) {
    const Outcome outcome =
        chasles(folder, std::string("run rec -o out --begin truth --stop 20 --json --quiet "
                                    "--realtime-speed ") +
                            speed);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const Json all = Json::parse(outcome.out), realtime = all.at("realtime");
    const auto estimated = all.at("frames").get<long>();
    EXPECT_EQ(realtime.at("speed"), std::stod(speed));
    EXPECT_EQ(realtime.at("frames_came"), 561);
    EXPECT_EQ(estimated + realtime.at("frames_dropped").get<long>() +
                  all.at("dropped_frames").get<long>(),
              561);
    const Json& latency = realtime.at("latency_ms");
    EXPECT_LE(latency.at("p50"), latency.at("p99"));
    EXPECT_LE(latency.at("p99"), latency.at("max"));
    EXPECT_LE(latency.at("mean"), latency.at("max"));
    const chasles::Run run = read_run(folder / "out");
    EXPECT_EQ(static_cast<long>(run.states.size()), estimated);
    expect_rising(run.states);
    EXPECT_EQ(Json::parse(slurp(folder / "out/timing.json")).at("realtime"), realtime);
    EXPECT_EQ(Json::parse(slurp(folder / "out/summary.json")).count("realtime"), 0u);
  }
}

TEST(Realtime, IsReportedOnTheCommandLine) {
  const Scratch folder;
  simulate_hallway(folder);
  const Outcome outcome = chasles(folder, "run rec --begin truth --stop 1 --realtime");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  expect_part(outcome.out, "real time x 1: 29 frames came, ");
  expect_part(outcome.out, "latency from a frame to its estimate: mean ");
}

TEST(Realtime, WithoutItNothingIsReportedOfIt) {
  const Scratch folder;
  simulate_hallway(folder);
  const Outcome outcome = chasles(folder, "run rec --begin truth --stop 1 --json --quiet");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(Json::parse(outcome.out).count("realtime"), 0u);
}

// The recording would last a day.
TEST(Realtime, AnInterruptEndsTheWait) {
  const Scratch folder;
  simulate_hallway(folder);
  const std::string rec = (folder / "rec").string(), out = (folder / "out").string();
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", O_WRONLY, 0);
  std::vector<std::string> words = {"chasles",          "run",   rec,       "-o",   out,
                                    "--realtime-speed", "0.001", "--begin", "truth"};
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  pid_t process = 0;
  ASSERT_EQ(posix_spawn(&process, CHASLES_BINARY, &actions, nullptr, argv.data(), environ), 0);
  posix_spawn_file_actions_destroy(&actions);
  // The folder is created after the signal handler is installed.
  while (!std::filesystem::exists(folder / "out")) ::usleep(1000);
  ::kill(process, SIGINT);
  int status = 0;
  ASSERT_EQ(::waitpid(process, &status, 0), process);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  const Json summary = Json::parse(slurp(folder / "out/summary.json"));
  expect_part(summary.at("remarks").dump(), "interrupted after ");
}

TEST(Realtime, RejectsWhatItCannotDo) {
  const Scratch folder;
  simulate(folder);
  expect_error(chasles(folder, "run rec --realtime"), 1,
               "--realtime is for a recording with an IMU");
  expect_error(chasles(folder, "run rec --realtime-speed 0"), 1, "--realtime-speed: found 0");
  expect_error(chasles(folder, "run rec --realtime-speed fast"), 1, "--realtime-speed");
}

TEST(Realtime, QuantilesAreThoseOfTheSortedValues) {
  std::vector<double> values;
  for (int i = 1; i <= 200; ++i) values.push_back((i * 77) % 200 + 1);  // 1 … 200, each once
  EXPECT_EQ(app::quantile(values, 0.5), 100);
  EXPECT_EQ(app::quantile(values, 0.99), 198);
  EXPECT_EQ(app::quantile(values, 1), 200);
  EXPECT_EQ(app::quantile({7}, 0.01), 7);
  EXPECT_TRUE(std::isnan(app::quantile({}, 0.5)));
}

TEST(Realtime, OfNoEstimateHasNoLatency) {
  const auto json =
      app::realtime_json({.speed = 2, .frames = {.came = 3, .taken = 0, .dropped = 3}});
  EXPECT_TRUE(json.at("latency_ms").at("mean").is_null());
  EXPECT_TRUE(json.at("latency_ms").at("max").is_null());
  expect_part(app::realtime_text(json), "real time x 2: 3 frames came, 3 dropped");
}

}  // namespace
}  // namespace chasles::test
