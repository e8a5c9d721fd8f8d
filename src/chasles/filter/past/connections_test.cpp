#include <algorithm>
#include <deque>

#include <chasles/filter/past/connections.hpp>
#include <chasles/filter/past/random_segments_testing.hpp>

// Smoothing of runs in which many landmarks return, again and again, against one segment with all
// cross-covariances.

namespace chasles {
namespace {

using Eigen::Index;

struct BusyRun {
  std::deque<Segment> segments;
  std::deque<std::vector<int>> revived;
  test::AllItems all_items;
  std::vector<int> returns_later;  // landmarks that are away and do, at the start of each segment
  int most_changes = 0;            // rows that leave or return in a segment

  std::vector<Stretch> stretches() const {
    std::vector<Stretch> result;
    for (std::size_t i = 0; i < segments.size(); ++i) result.push_back({&segments[i], &revived[i]});
    return result;
  }
};

// Each of the landmarks of a small place returns several times; with a `pause`, not until so many
// segments have ended, in which as many landmarks leave.
BusyRun busy_run(int seed, int count, int each, int pause = 0) {
  test::Random random(seed);
  BusyRun run;
  std::vector<int> away, returned;
  int next = 0;
  for (int i = 0; i < count; ++i) {
    const bool returns = i > 3 && (pause > 0 ? i % pause == 0 : i % 3 != 0);
    run.revived.push_back(returns ? test::some_of(random, away, each) : std::vector<int>{});
    for (const int number : run.revived.back()) std::erase(away, number);
    if (!run.revived.back().empty()) run.all_items.revive(run.revived.back());
    const int leaving = i < 3       ? 10
                        : pause > 0 ? i % (each + 1)
                                    : static_cast<int>(run.revived.back().size());
    run.segments.push_back(
        test::random_segment(random, run.all_items.rows(), 8 + i % 3, next, leaving));
    for (int k = 0; k < leaving; ++k) away.push_back(next++);
    run.all_items.append(run.segments.back());
    returned.insert(returned.end(), run.revived.back().begin(), run.revived.back().end());
    run.most_changes =
        std::max(run.most_changes, 3 * (leaving + static_cast<int>(run.revived.back().size())));
  }
  std::ranges::sort(returned);
  int away_now = 0;
  for (std::size_t i = 0; i < run.segments.size(); ++i) {
    away_now -= static_cast<int>(run.revived[i].size());
    run.returns_later.push_back(away_now);
    away_now += static_cast<int>(
        std::ranges::count_if(run.segments[i].items, [&](const Segment::Item& item) {
          return std::ranges::binary_search(returned, item.number);
        }));
  }
  return run;
}

void expect_smooths(const BusyRun& run) {
  const std::vector<SmoothedState> smoothed = smooth_segments(run.stretches());
  const Segment& all = run.all_items.all();
  ASSERT_EQ(smoothed.size(), all.items.size());
  for (std::size_t i = 0; i < smoothed.size(); ++i) {
    ASSERT_EQ(smoothed[i].number, all.items[i].number);
    const Index at = 3 * static_cast<Index>(i);
    EXPECT_TRUE(test::agree(smoothed[i].correction, all.g.segment<3>(at), 1e-7, 1e-9));
    EXPECT_TRUE(test::agree(smoothed[i].covariance, all.G.block<3, 3>(at, at), 1e-7, 1e-9));
  }
}

TEST(Connections, SmoothingIsThatOfOneSegmentWithAllItems) {
  for (const int each : {1, 4, 12}) {
    SCOPED_TRACE(each);
    expect_smooths(busy_run(each, 90, each));
  }
}

// Segments between two returns share their U.
TEST(Connections, SmoothingWithRareReturns) {
  for (const int each : {1, 4}) {
    SCOPED_TRACE(each);
    expect_smooths(busy_run(each, 100, each, 17));
  }
}

TEST(Connections, ThereAreHardlyMorePlacesThanLandmarksAway) {
  const BusyRun run = busy_run(5, 130, 5);
  EXPECT_GT(returning_numbers(run.stretches()).size(), 300u);
  const int most = *std::ranges::max_element(run.returns_later);
  EXPECT_LE(most, 30);
  for (const Connection& connection : connections_of(run.stretches())) {
    EXPECT_LE(connection.places(), 3 * most + std::max(30, 2 * run.most_changes));
  }
}

// Then nothing has a place.
TEST(Connections, AllReturnAndLeaveAgain) {
  const BusyRun run = busy_run(7, 40, 300);
  EXPECT_GT(std::ranges::count(run.returns_later, 0), 12);
  expect_smooths(run);
}

}  // namespace
}  // namespace chasles
