#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/testing.hpp>
#include <chasles/run_folder/growing_run.hpp>

namespace chasles {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

constexpr GrowingRun::Pace kAtOnce{.first = 0ms, .between = 0ms, .share = 0};
const nlohmann::ordered_json kSummary{{"chart", "standard"}};

Run run_of(int states) {
  Run run{.name = "walk",
          .extra_names = {"bias_x"},
          .states = {},
          .landmarks = {},
          .truth = {},
          .dead_reckoning = {}};
  for (int k = 0; k < states; ++k) {
    RunState& s = run.states.emplace_back();
    s.time = Time(1'000'000'000LL + 50'000'000LL * k);
    s.world_T_imu.p = {0.1 * k, 1, 2};
    s.pose_covariance.setIdentity();
    s.extra = {0.5 * k};
    s.extra_sigma = {0.1};
    s.health = "ok";
    run.truth.push_back({.time = s.time, .pose = s.world_T_imu});
  }
  return run;
}

auto map_of(int count) {
  return [count] { return std::vector<RunLandmark>(static_cast<std::size_t>(count)); };
}

TEST(GrowingRun, IsARunFolderOfWhatThereIsSoFar) {
  const auto folder = test::scratch() / "out";
  GrowingRun growing(folder, kAtOnce);
  growing.begin(run_of(0), kSummary);
  growing.extend(run_of(0), map_of(0));
  EXPECT_FALSE(fs::exists(growing_folder(folder) / "summary.json")) << "there is nothing yet";
  for (const int states : {3, 3, 8}) {
    growing.extend(run_of(states), map_of(states - 1));
    const auto read = read_run(growing_folder(folder)), run = run_of(states);
    EXPECT_EQ(read.name, "walk");
    EXPECT_EQ(read.extra_names, run.extra_names);
    EXPECT_EQ(std::ssize(read.landmarks), states - 1);
    EXPECT_EQ(read.truth.size(), 3U) << "written once: it is known from the beginning";
    ASSERT_EQ(read.states.size(), run.states.size());
    for (std::size_t k = 0; k < run.states.size(); ++k) {
      EXPECT_EQ(read.states[k].time, run.states[k].time);
      EXPECT_EQ(read.states[k].world_T_imu.p, run.states[k].world_T_imu.p);
      EXPECT_EQ(read.states[k].extra, run.states[k].extra);
    }
  }
  EXPECT_EQ(read_summary(growing_folder(folder))["chart"], "standard");
}

TEST(GrowingRun, HoldsItsFolderUntilItsEndAndLeavesNothing) {
  const auto folder = test::scratch() / "out";
  EXPECT_FALSE(is_growing(folder));
  {
    const GrowingRun growing(folder);
    EXPECT_TRUE(is_growing(folder));
    EXPECT_TRUE(is_growing(folder)) << "to look does not take it";
    EXPECT_THROW(GrowingRun{folder}, UsageError);
    EXPECT_TRUE(is_growing(folder));
  }
  EXPECT_FALSE(is_growing(folder));
  EXPECT_TRUE(fs::is_empty(folder));
}

TEST(GrowingRun, StaysWhereTheResultsWereNotWritten) {
  const auto folder = test::scratch() / "out";
  {
    GrowingRun growing(folder, kAtOnce);
    growing.begin(run_of(0), kSummary);
    growing.extend(run_of(3), map_of(1));
  }
  EXPECT_FALSE(is_growing(folder));
  EXPECT_EQ(read_run(growing_folder(folder)).states.size(), 3U);
}

TEST(GrowingRun, RowsThatWereCutOffAreLeftOut) {
  const auto folder = test::scratch() / "out";
  GrowingRun growing(folder, kAtOnce);
  growing.begin(run_of(0), kSummary);
  growing.extend(run_of(3), map_of(1));
  const auto states = growing_folder(folder) / "states.csv";
  const std::string whole = test::slurp(states);
  test::spill(states, whole + "1150000000,0.3");
  EXPECT_EQ(read_run(growing_folder(folder)).states.size(), 3U);
  test::spill(states, whole + std::string(100, '\0'));  // as after a power cut
  EXPECT_EQ(read_run(growing_folder(folder)).states.size(), 3U);
  test::spill(states, whole.substr(0, whole.size() - 1));
  test::expect_parts(test::input_error([&] { read_run(growing_folder(folder)); }),
                     {"states.csv", "truncated"});
}

TEST(GrowingRun, WhatAKilledRunLeftIsNamedAndThenReplaced) {
  const auto folder = test::scratch() / "out";
  make_folder(growing_folder(folder));
  write_file(growing_folder(folder) / "states.csv", "of a killed run\n");
  EXPECT_FALSE(is_growing(folder));
  test::expect_parts(test::input_error([&] { read_run(folder); }),
                     {"is no run folder", "killed", growing_folder(folder).string()});
  GrowingRun growing(folder, kAtOnce);
  growing.begin(run_of(0), kSummary);
  growing.extend(run_of(2), map_of(0));
  EXPECT_EQ(read_run(growing_folder(folder)).states.size(), 2U);
  test::expect_parts(test::input_error([&] { read_run(folder); }), {"is being written"});
}

TEST(GrowingRun, NeverRemovesWhatItDidNotWrite) {
  const auto folder = test::scratch() / "out";
  make_folder(growing_folder(folder) / "plants");
  write_file(growing_folder(folder) / "notes.txt", "of the user\n");
  {
    GrowingRun growing(folder, kAtOnce);
    growing.begin(run_of(0), kSummary);
    growing.extend(run_of(2), map_of(0));
    EXPECT_TRUE(fs::exists(growing_folder(folder) / "states.csv"));
    growing.end();
  }
  EXPECT_FALSE(fs::exists(growing_folder(folder) / "states.csv"));
  EXPECT_TRUE(fs::exists(growing_folder(folder) / "notes.txt"));
  EXPECT_TRUE(fs::exists(growing_folder(folder) / "plants"));
}

TEST(GrowingRun, NothingIsWrittenOfAShortRunAndLittleOfALongOne) {
  const auto root = test::scratch();
  const auto folder = root / "out", other = root / "other";
  GrowingRun growing(folder, {.first = 1h, .between = 0ms, .share = 0});
  growing.begin(run_of(0), kSummary);
  growing.extend(run_of(5), []() -> std::vector<RunLandmark> {
    ADD_FAILURE() << "the map was requested";
    return {};
  });
  EXPECT_TRUE(fs::is_empty(growing_folder(folder)));

  GrowingRun slow(other, {.first = 0ms, .between = 1h, .share = 0});
  slow.begin(run_of(0), kSummary);
  slow.extend(run_of(2), map_of(0));
  slow.extend(run_of(5), map_of(0));
  EXPECT_EQ(read_run(growing_folder(other)).states.size(), 2U);
}

TEST(GrowingRun, ADiskThatFailsDoesNotEndTheRun) {
  const auto folder = test::scratch() / "out";
  GrowingRun growing(folder, kAtOnce);
  growing.begin(run_of(0), kSummary);
  fs::remove_all(growing_folder(folder));
  int asked = 0;
  const auto map = [&asked] {
    ++asked;
    return std::vector<RunLandmark>();
  };
  EXPECT_NO_THROW(growing.extend(run_of(2), map));
  EXPECT_NO_THROW(growing.extend(run_of(4), map));
  EXPECT_EQ(asked, 1) << "it has given up";
}

}  // namespace
}  // namespace chasles
