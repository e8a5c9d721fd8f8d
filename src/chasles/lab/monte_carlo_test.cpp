#include <cmath>
#include <map>

#include <gtest/gtest.h>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/lab/monte_carlo.hpp>

namespace chasles {
namespace {

TrialRecord record(std::uint64_t run, double position, double nees_pose,
                   std::vector<double> nees_of_seconds = {}) {
  TrialRecord r{.filter = "a", .run = run, .diverged = false, .averages = {}, .seconds = {}};
  r.averages.position_error = position;
  r.averages.nees_pose = nees_pose;
  for (const double nees : nees_of_seconds) {
    r.seconds.push_back({.position_error = position, .nees_pose = nees});
  }
  return r;
}

FilterSummary summary_of(const std::vector<TrialRecord>& records) {
  const std::vector<FilterVariant> filters{{.name = "a", .settings = {}}};
  return summarize(filters, records).front();
}

TEST(Summarize, AveragesAndMediansAreOverTheRuns) {
  const FilterSummary s = summary_of({record(2, 6, 30), record(0, 1, 6), record(1, 2, 9)});
  EXPECT_EQ(s.runs, 3u);
  EXPECT_EQ(s.diverged, 0u);
  EXPECT_DOUBLE_EQ(s.mean.position_error, 3);
  EXPECT_DOUBLE_EQ(s.median.position_error, 2);
  EXPECT_DOUBLE_EQ(s.mean.nees_pose, 15);
  EXPECT_DOUBLE_EQ(s.median.nees_pose, 9);
  EXPECT_DOUBLE_EQ(s.nees_per_dof, 2.5);
  EXPECT_DOUBLE_EQ(s.covariance_factor, 2.5);
}

TEST(Summarize, CountsDivergedRunsAndLeavesThemOutOfTheAverages) {
  std::vector<TrialRecord> records{record(0, 1, 6), record(1, 1e6, 1e9), record(2, 3, 6)};
  records[1].diverged = true;
  const FilterSummary s = summary_of(records);
  EXPECT_EQ(s.runs, 3u);
  EXPECT_EQ(s.diverged, 1u);
  EXPECT_DOUBLE_EQ(s.mean.position_error, 2);
  const Band two = chi2_band(6, 2);
  EXPECT_DOUBLE_EQ(s.band.low, two.low / 6);
  EXPECT_DOUBLE_EQ(s.band.high, two.high / 6);
}

TEST(Summarize, HasNoFiguresWhereAllDiverged) {
  std::vector<TrialRecord> records{record(0, 1, 6, {6})};
  records[0].diverged = true;
  const FilterSummary s = summary_of(records);
  EXPECT_EQ(s.diverged, 1u);
  EXPECT_TRUE(std::isnan(s.mean.position_error));
  EXPECT_TRUE(std::isnan(s.median.nees_pose));
  EXPECT_TRUE(std::isnan(s.seconds_inside));
  EXPECT_TRUE(s.seconds.empty());
}

TEST(Summarize, LeavesNaNOut) {
  const FilterSummary s = summary_of({record(0, 1, kNaN), record(1, 2, 12)});
  EXPECT_DOUBLE_EQ(s.mean.position_error, 1.5);
  EXPECT_DOUBLE_EQ(s.mean.nees_pose, 12);
}

TEST(Summarize, ShowsHowManySecondsAreInsideTheBand) {
  // Two runs: the mean of a chi-square variable of 6 degrees lies in 2.2 .. 11.7.
  const FilterSummary s =
      summary_of({record(0, 1, 6, {kNaN, 6, 30, 1}), record(1, 1, 6, {kNaN, 4, 10, 1, 7})});
  ASSERT_EQ(s.seconds.size(), 5u);
  EXPECT_TRUE(std::isnan(s.seconds[0].nees_pose));
  EXPECT_DOUBLE_EQ(s.seconds[1].nees_pose, 5);
  EXPECT_DOUBLE_EQ(s.seconds[2].nees_pose, 20);
  EXPECT_DOUBLE_EQ(s.seconds[4].nees_pose, 7);
  EXPECT_DOUBLE_EQ(s.seconds_inside, 0.5);  // 5 and 7 are, 20 and 1 are not
}

TEST(Summarize, DoesNotDependOnTheOrderOfRecords) {
  std::vector<TrialRecord> records;
  for (std::uint64_t run = 0; run < 20; ++run) {
    const double x = std::sin(static_cast<double>(run)) * 1e3;
    records.push_back(record(run, x, x, {x}));
  }
  const FilterSummary forward = summary_of(records);
  const FilterSummary backward = summary_of({records.rbegin(), records.rend()});
  EXPECT_EQ(forward.mean.position_error, backward.mean.position_error);
  EXPECT_EQ(forward.seconds[0].nees_pose, backward.seconds[0].nees_pose);
}

TEST(Record, AveragesEachSecond) {
  Trial trial{.filter = "a", .run = 4};
  for (const auto& [seconds, error, nees] :
       {std::tuple{0.0, 1.0, kNaN}, {0.5, 3.0, 4.0}, {1.0, 7.0, 5.0}, {3.2, 9.0, 6.0}}) {
    trial.points.push_back(
        {.seconds = seconds, .position_error = error, .nees_pose = nees, .nis = 6, .nis_dof = 4});
  }
  const TrialRecord r = record_of(trial);
  EXPECT_EQ(r.run, 4u);
  EXPECT_TRUE(r.smoothed.empty());
  ASSERT_EQ(r.seconds.size(), 4u);
  EXPECT_DOUBLE_EQ(r.seconds[0].position_error, 2);
  EXPECT_DOUBLE_EQ(r.seconds[0].nees_pose, 4);
  EXPECT_DOUBLE_EQ(r.seconds[1].position_error, 7);
  EXPECT_TRUE(std::isnan(r.seconds[2].position_error)) << "no frame in this second";
  EXPECT_DOUBLE_EQ(r.averages.position_error, 5);
  EXPECT_DOUBLE_EQ(r.averages.position_rms, std::sqrt(35.0));
  EXPECT_DOUBLE_EQ(r.averages.nees_pose, 5);
  EXPECT_DOUBLE_EQ(r.averages.nis_per_dof, 1.5);
}

TEST(Record, AveragesEachSecondOfTheSmoothedPath) {
  Trial trial{.filter = "a"};
  trial.smoothed = {{.seconds = 0.2, .nees_pose = 2}, {.seconds = 0.4, .nees_pose = 4}};
  const TrialRecord r = record_of(trial);
  EXPECT_TRUE(r.seconds.empty());
  ASSERT_EQ(r.smoothed.size(), 1u);
  EXPECT_DOUBLE_EQ(r.smoothed[0].nees_pose, 3);
}

MonteCarloPlan small_plan() {
  MonteCarloPlan plan{.scene = inertial_scene("turntable"), .filters = {}, .runs = {5, 0, 2}};
  plan.scene.settings.revolutions = 0.15;
  plan.filters.push_back({.name = "own", .settings = {}});
  plan.filters.push_back({.name = "standard", .settings = {}});
  plan.filters.back().settings.chart = "standard";
  return plan;
}

std::map<std::uint64_t, std::vector<TrialRecord>> run(const MonteCarloPlan& plan, int workers) {
  std::map<std::uint64_t, std::vector<TrialRecord>> all;
  run_monte_carlo(plan, workers, [&](std::span<const TrialRecord> records) {
    all[records.front().run].assign(records.begin(), records.end());
  });
  return all;
}

TEST(MonteCarlo, GivesTheSameNumbersForAnyNumberOfWorkers) {
  MonteCarloPlan plan = small_plan();
  plan.filters.back().settings.exact_map = Toggle::kTrue;
  const auto one = run(plan, 1), three = run(plan, 3);
  ASSERT_EQ(one.size(), 3u);
  ASSERT_EQ(three.size(), 3u);
  for (const auto& [number, records] : one) {
    ASSERT_EQ(records.size(), 2u);
    for (std::size_t f = 0; f < 2; ++f) {
      const TrialRecord &a = records[f], &b = three.at(number)[f];
      EXPECT_EQ(a.filter, plan.filters[f].name);
      EXPECT_EQ(a.filter, b.filter);
      EXPECT_EQ(a.averages.position_error, b.averages.position_error);
      EXPECT_EQ(a.averages.nees_pose, b.averages.nees_pose);
      EXPECT_EQ(a.averages.nis_per_dof, b.averages.nis_per_dof);
      EXPECT_EQ(a.seconds.size(), b.seconds.size());
      ASSERT_EQ(a.smoothed.size(), f == 0 ? 0 : a.seconds.size());
      ASSERT_EQ(a.smoothed.size(), b.smoothed.size());
      for (std::size_t i = 0; i < a.smoothed.size(); ++i) {
        EXPECT_EQ(a.smoothed[i].position_error, b.smoothed[i].position_error);
      }
    }
  }
  EXPECT_NE(one.at(0)[0].averages.position_error, one.at(2)[0].averages.position_error);
}

TEST(MonteCarlo, RejectsASceneThatCannotBeSimulated) {
  MonteCarloPlan plan = small_plan();
  plan.scene.settings.radial_sway = 1e3;
  for (const int workers : {1, 2}) {
    try {
      run(plan, workers);
      FAIL() << "nothing was rejected";
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::kUsage);
      EXPECT_NE(std::string(error.what()).find("radial_sway"), std::string::npos);
    }
  }
}

}  // namespace
}  // namespace chasles
