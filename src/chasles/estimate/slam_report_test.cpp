#include <gtest/gtest.h>

#include <chasles/estimate/slam_report.hpp>

namespace chasles {
namespace {

// Every count of a part is a number of its own, so that a sum with the wrong one differs.
SlamReport part(int n) {
  return {.imu = {.used = n,
                  .not_finite = 2 * n,
                  .not_later = 3 * n,
                  .zero = 4 * n,
                  .spikes = 5 * n,
                  .frozen = 6 * n,
                  .interpolated = 10 * n,
                  .gaps = 7 * n,
                  .saturated = 8 * n,
                  .extrapolated = 9 * n},
          .timed = {.used = 11 * n, .rejected = 12 * n, .late = 13 * n},
          .resets = 14 * n,
          .dropped_frames = 15 * n,
          .places = {.searches = 16 * n, .proposed = 17 * n, .rejected = 18 * n},
          .closures = {{.time = Time(n), .landmarks = n}},
          .recognised = {Time(n), Time(n + 1)}};
}

void expect_counts(const SlamReport& report, const SlamReport& expected) {
  EXPECT_EQ(report.imu.used, expected.imu.used);
  EXPECT_EQ(report.imu.not_finite, expected.imu.not_finite);
  EXPECT_EQ(report.imu.not_later, expected.imu.not_later);
  EXPECT_EQ(report.imu.zero, expected.imu.zero);
  EXPECT_EQ(report.imu.spikes, expected.imu.spikes);
  EXPECT_EQ(report.imu.frozen, expected.imu.frozen);
  EXPECT_EQ(report.imu.interpolated, expected.imu.interpolated);
  EXPECT_EQ(report.imu.gaps, expected.imu.gaps);
  EXPECT_EQ(report.imu.saturated, expected.imu.saturated);
  EXPECT_EQ(report.imu.extrapolated, expected.imu.extrapolated);
  EXPECT_EQ(report.timed.used, expected.timed.used);
  EXPECT_EQ(report.timed.rejected, expected.timed.rejected);
  EXPECT_EQ(report.timed.late, expected.timed.late);
  EXPECT_EQ(report.resets, expected.resets);
  EXPECT_EQ(report.dropped_frames, expected.dropped_frames);
  EXPECT_EQ(report.places.searches, expected.places.searches);
  EXPECT_EQ(report.places.proposed, expected.places.proposed);
  EXPECT_EQ(report.places.rejected, expected.places.rejected);
}

TEST(SlamReport, CountsAddUpAndListsKeepTheOrderOfTheParts) {
  SlamReport report = part(1);
  report.merge(part(100));
  expect_counts(report, part(101));
  ASSERT_EQ(report.closures.size(), 2u);
  EXPECT_EQ(report.closures[0].landmarks, 1);
  EXPECT_EQ(report.closures[1].landmarks, 100);
  EXPECT_EQ(report.recognised, (std::vector<Time>{Time(1), Time(2), Time(100), Time(101)}));
}

TEST(SlamReport, AnEmptyPartChangesNothing) {
  SlamReport before, after = part(3);
  before.merge(part(3));
  after.merge({});
  for (const SlamReport* report : {&before, &after}) {
    expect_counts(*report, part(3));
    EXPECT_EQ(report->closures.size(), 1u);
    EXPECT_EQ(report->recognised.size(), 2u);
  }
}

TEST(SlamReport, TheLastPlaceCounts) {
  SlamReport report;
  report.places.placed = Time(5);
  report.merge({});
  EXPECT_EQ(report.places.placed, Time(5)) << "a later part that found none keeps it";
  SlamReport later;
  later.places.placed = Time(9);
  report.merge(later);
  EXPECT_EQ(report.places.placed, Time(9));
}

TEST(SlamReport, ATrackKeepsTheLandmarkThatWasFoundFirst) {
  SlamReport report{.known_as = {{7, 1}}};
  report.merge({.known_as = {{7, 2}, {8, 3}}});
  EXPECT_EQ(report.known_as, (std::map<LandmarkId, LandmarkId>{{7, 1}, {8, 3}}));
}

}  // namespace
}  // namespace chasles
