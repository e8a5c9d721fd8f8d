#include <chrono>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chasles/live/live_run.hpp>
#include <chasles/live/server.hpp>
#include <chasles/live/testing.hpp>
#include <chasles/report/page_data.hpp>
#include <chasles/report/testing.hpp>

namespace chasles {
namespace {

using Json = nlohmann::json;
using test::column;
using test::synthetic_drive;

LiveStart start_of(const ReportRun& drive) {
  return {.name = drive.run.name,
          .extra_names = drive.run.extra_names,
          .truth = drive.run.truth,
          .dead_reckoning = drive.run.dead_reckoning,
          .summary = drive.summary,
          .frames = drive.run.states.size()};
}

/// A viewer that combines the pieces, as src/web/src/live_rows.ts does.
struct Viewer {
  LiveCursor cursor = {};
  std::map<std::string, std::vector<double>> states = {}, errors = {};
  Json first = {}, last = {}, landmarks = {}, truth = {};
  int texts = 0;
  std::size_t largest = 0;

  void take(LiveRun& run) {
    while (const LiveText text = run.next(cursor)) {
      largest = std::max(largest, text->size());
      ++texts;
      last = Json::parse(*text);
      if (last.contains("data")) put(last);
    }
  }

  void put(const Json& json) {
    const Json& data = json["data"];
    if (json["from"] == 0) {
      states = errors = {};
      first = json;
    }
    ASSERT_EQ(json["from"], states.empty() ? 0 : states.begin()->second.size());
    append(states, data["states"], json["skip"]);
    if (data.contains("errors")) append(errors, data["errors"], json["skip"]);
    if (data.contains("landmarks")) landmarks = data["landmarks"];
    if (data.contains("truth")) truth = data["truth"];
    ASSERT_EQ(states.begin()->second.size(), json["rows"]);
  }

  static void append(std::map<std::string, std::vector<double>>& to, const Json& columns,
                     std::size_t skip) {
    for (const auto& [name, text] : columns.items()) {
      const std::vector<double> values = column(text);
      to[name].insert(to[name].end(), values.begin() + static_cast<std::ptrdiff_t>(skip),
                      values.end());
    }
  }
};

void expect_same(const std::map<std::string, std::vector<double>>& found, const Json& columns,
                 double tolerance) {
  ASSERT_EQ(found.size(), columns.size());
  for (const auto& [name, text] : columns.items()) {
    const std::vector<double> expected = column(text);
    ASSERT_EQ(found.at(name).size(), expected.size()) << name;
    for (std::size_t i = 0; i < expected.size(); ++i) {
      if (std::isnan(expected[i]) && std::isnan(found.at(name)[i])) continue;
      ASSERT_NEAR(found.at(name)[i], expected[i], tolerance * (1 + std::abs(expected[i])))
          << name << " " << i;
    }
  }
}

Json whole(const ReportRun& drive) { return Json::parse(page_data({drive}).dump())["runs"][0]; }

TEST(LiveRun, ThePiecesAreTheRunAsTheReportHasIt) {
  ReportRun drive = synthetic_drive({.states = 700, .landmarks = 30});
  drive.summary = R"({"chart": "right-sen3", "settings": {"gate": 0.99}})";
  // The truth starts later: errors exist from its first pose on.
  drive.run.truth.erase(drive.run.truth.begin(), drive.run.truth.begin() + 40);
  LiveRun run([] {});
  Viewer viewer;
  run.begin(start_of(drive));
  run.refresh(1);
  viewer.take(run);
  EXPECT_EQ(viewer.last["progress"]["stage"], "waiting");
  EXPECT_EQ(viewer.last["progress"]["of"], 700);
  for (std::size_t i = 0; i < drive.run.states.size(); ++i) {
    run.add(drive.run.states[i]);
    run.progress(i + 1, 0.1 * static_cast<double>(i));
    if (i % 37 != 5) continue;
    run.refresh(1);
    viewer.take(run);
  }
  run.refresh(1);
  viewer.take(run);
  const Json expected = whole(drive);
  Json states = expected["states"];
  states.erase("health");  // its names are counted in each piece
  viewer.states.erase("health");
  expect_same(viewer.states, states, 0);
  expect_same({{"x", column(viewer.truth["first_x"])}}, {{"x", expected["truth"]["first_x"]}},
              1e-6);
  ASSERT_EQ(viewer.errors.size(), expected["errors"].size());
  // The first pieces had no truth: its rows are the last ones.
  const std::size_t missing = 700 - viewer.errors["nees_pose"].size();
  EXPECT_EQ(missing, 6U);
  for (auto& [name, values] : viewer.errors) values.insert(values.begin(), missing, std::nan(""));
  expect_same(viewer.errors, expected["errors"], 0);
  EXPECT_EQ(viewer.last["progress"]["stage"], "running");
  EXPECT_EQ(viewer.first["data"]["summary"]["settings"]["gate"], 0.99);
  EXPECT_TRUE(viewer.first["data"].contains("dead_reckoning"));
}

TEST(LiveRun, WhoeverJoinsLateOrAgainGetsWhatIsMissing) {
  const ReportRun drive = synthetic_drive({.states = 6000, .landmarks = 0});
  LiveRun run([] {});
  run.begin(start_of(drive));
  for (const RunState& state : drive.run.states) run.add(state);
  run.refresh(0);
  Viewer late;
  late.take(run);
  EXPECT_EQ(late.texts, 3);
  EXPECT_LT(late.largest, 1'000'000U);
  EXPECT_EQ(late.states["x"].size(), 6000U);
  EXPECT_EQ(late.errors["nees_pose"].size(), 6000U);
  EXPECT_EQ(late.cursor.rows, 6000U);
  // A new connection that reports where the old one ended.
  Viewer again = late;
  again.texts = 0;
  again.cursor.progress = 0;
  run.add(drive.run.states.back());
  run.refresh(1);
  again.take(run);
  EXPECT_EQ(again.texts, 1);
  EXPECT_EQ(again.last["from"], 6000);
  // A viewer with data of another run, or that claims more than exists, receives everything.
  for (const LiveCursor& cursor : {LiveCursor{.run = "other", .rows = 10}, LiveCursor{}}) {
    Viewer other{.cursor = cursor};
    other.take(run);
    EXPECT_EQ(other.states["x"].size(), 6001U);
  }
  Viewer liar{.cursor = {.run = late.cursor.run, .rows = 999'999'999}};
  liar.take(run);
  EXPECT_EQ(liar.states["x"].size(), 6001U);
}

TEST(LiveRun, LandmarksAreAskedForOnlyWhereAViewerIsAndOnceInASecond) {
  const ReportRun drive = synthetic_drive({.states = 10, .landmarks = 20});
  LiveRun run([] {});
  int asked = 0;
  const auto make = [&] {
    ++asked;
    return LiveMap{.landmarks = drive.run.landmarks};
  };
  run.begin(start_of(drive));
  run.add(drive.run.states[0]);
  run.map(make);
  EXPECT_EQ(asked, 0);
  run.refresh(1);
  for (int i = 0; i < 5; ++i) run.map(make);
  EXPECT_EQ(asked, 1);
  run.refresh(1);
  Viewer viewer;
  viewer.take(run);
  ReportRun part = drive;
  part.run.states.resize(1);
  EXPECT_EQ(viewer.landmarks, whole(part)["landmarks"]);
  run.add(drive.run.states[1]);
  run.refresh(1);
  viewer.take(run);
  EXPECT_FALSE(viewer.last["data"].contains("landmarks"));
}

TEST(LiveRun, ThePlaceInAMapAndTheClosuresComeWithTheLandmarks) {
  const ReportRun drive = synthetic_drive({.states = 10, .landmarks = 20, .prior_map = true});
  LiveRun run([] {});
  run.begin(start_of(drive));
  run.add(drive.run.states[0]);
  run.refresh(1);
  run.map([&] {
    return LiveMap{.landmarks = drive.run.landmarks,
                   .known = R"({"closures": [{"seconds": 0, "landmarks": 5}]})",
                   .prior_map = drive.run.prior_map};
  });
  run.refresh(1);
  Viewer viewer;
  viewer.take(run);
  ReportRun part = drive;
  part.run.states.resize(1);
  EXPECT_EQ(viewer.last["data"]["map"], whole(part)["map"]);
  EXPECT_EQ(viewer.last["known"]["closures"][0]["landmarks"], 5);
  // Once.
  run.add(drive.run.states[1]);
  run.refresh(1);
  viewer.take(run);
  EXPECT_FALSE(viewer.last["data"].contains("map"));
  Viewer late{.cursor = {.run = viewer.cursor.run, .rows = 1, .landmarks = 1}};
  late.states["x"] = {0};
  const LiveText text = run.next(late.cursor);
  ASSERT_TRUE(text);
  EXPECT_TRUE(Json::parse(*text)["data"].contains("map"));
}

TEST(LiveRun, TheEndIsTheReportsPage) {
  const ReportRun drive = synthetic_drive({.states = 60, .landmarks = 20});
  LiveRun run([] {});
  run.begin(start_of(drive));
  run.finish(drive, false);
  run.refresh(2);
  Viewer one, two;
  two.cursor.run = "of another";
  one.take(run);
  two.take(run);
  EXPECT_EQ(one.texts, 1);
  EXPECT_EQ(one.last["progress"]["stage"], "finished");
  EXPECT_EQ(one.last["all"], Json::parse(page_data({drive}).dump()));
  EXPECT_EQ(one.last, two.last);
  LiveRun stopped([] {}), failed([] {});
  stopped.finish(drive, true);
  failed.fail("no start was found");
  Viewer of_stopped, of_failed;
  stopped.refresh(1);
  failed.refresh(1);
  of_stopped.take(stopped);
  of_failed.take(failed);
  EXPECT_EQ(of_stopped.last["progress"]["stage"], "interrupted");
  EXPECT_EQ(of_failed.last["progress"]["stage"], "failed");
  EXPECT_EQ(of_failed.last["progress"]["message"], "no start was found");
}

TEST(LiveRun, FinishedRunsAreServedOnce) {
  const ReportRun drive = synthetic_drive({.states = 60, .landmarks = 20});
  FinishedRuns runs({drive, drive});
  LiveCursor cursor;
  const Json json = Json::parse(*runs.next(cursor));
  EXPECT_EQ(json["all"]["runs"].size(), 2U);
  EXPECT_FALSE(runs.next(cursor));
  LiveCursor again{.run = cursor.run, .all = true};
  EXPECT_FALSE(runs.next(again));
}

TEST(LiveRun, AViewerThatReadsNothingDoesNotHoldUpTheRun) {
  const ReportRun drive = synthetic_drive({.states = 1000, .landmarks = 3000});
  std::vector<int> stops;
  LiveRun run([&] { stops.push_back(1); });
  LiveServer server({}, "", run);
  run.begin(start_of(drive));
  test::Client deaf = test::viewer(server.gate().port, 4096);
  double slowest = 0;
  for (int round = 0; round < 30; ++round) {
    for (const RunState& state : drive.run.states) {
      const auto start = std::chrono::steady_clock::now();
      run.add(state);
      run.progress(1, 1);
      const std::chrono::duration<double> took = std::chrono::steady_clock::now() - start;
      slowest = std::max(slowest, took.count());
    }
  }
  // Other processes may delay this; a waiting run would never end.
  EXPECT_LT(slowest, 0.5);
}

}  // namespace
}  // namespace chasles
