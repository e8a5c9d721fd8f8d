#include <algorithm>
#include <set>

#include <chasles/filter/past/random_segments_testing.hpp>
#include <chasles/filter/past/segment_chain.hpp>

// A chain of segments against one segment that has all items and all their cross-covariances.

namespace chasles {
namespace {

using Eigen::Index;

void expect_equal(const Carried& a, const Carried& b) {
  ASSERT_EQ(a.items.size(), b.items.size());
  for (std::size_t i = 0; i < a.items.size(); ++i) EXPECT_EQ(a.items[i].number, b.items[i].number);
  EXPECT_TRUE(test::agree(a.C, b.C, 1e-11, 1e-9));
  EXPECT_TRUE(test::agree(a.P, b.P, 1e-11, 1e-9));
  EXPECT_TRUE(test::agree(a.correction, b.correction, 1e-11, 1e-9));
}

// A run of segments in which landmarks leave, and some return.
class Walk {
 public:
  explicit Walk(int seed, std::size_t spare_bytes = SegmentChain::kSpareBytes)
      : random_(seed), spare_bytes_(spare_bytes), chain_(spare_bytes) {}

  void step(int leaving, int returning) {
    const Index end = 6 + static_cast<Index>(random_.next() % 4);
    const Segment segment = test::random_segment(random_, all_items_.rows(), end, next_, leaving);
    for (int i = 0; i < leaving; ++i) there_.insert(next_++);
    all_items_.append(segment);
    all_items_.keep(there());
    chain_.append(segment, [&](int number) { return there_.contains(number); });
    const std::size_t rows = 3 * there_.size();
    EXPECT_LE(chain_.bytes(), 2 * sizeof(double) * rows * rows + spare_bytes_);
    const std::vector<int> numbers = test::some_of(random_, there(), returning);
    for (const int number : numbers) there_.erase(number);
    if (!numbers.empty()) expect_equal(chain_.revive(numbers), all_items_.revive(numbers));
  }
  void expect_recalls() const {
    const std::vector<int> all = there();
    expect_equal(chain_.recall(all), all_items_.recall(all));
  }
  void expect_composes() const {
    const std::vector<int> all = there();
    const Segment composed = chain_.composed([&](int number) { return there_.contains(number); });
    EXPECT_EQ(composed.starts, 0);
    Carried past;
    carry(past, composed, all);
    expect_equal(past, all_items_.recall(all));
  }
  void discard(int below) {
    std::erase_if(there_, [&](int number) { return number < below; });
  }
  int landmarks() const { return static_cast<int>(there_.size()); }

 private:
  std::vector<int> there() const { return {there_.begin(), there_.end()}; }

  test::Random random_;
  std::size_t spare_bytes_;
  test::AllItems all_items_;
  SegmentChain chain_;
  std::set<int> there_;
  int next_ = 0;
};

TEST(SegmentChain, RecallsAndReturnsAsOneSegmentWithAllCovariancesDoes) {
  Walk walk(1);
  for (int i = 0; i < 60; ++i) {
    walk.step(1 + i % 4, i % 3 == 0 ? i % 5 : 0);
    walk.expect_recalls();
  }
  walk.expect_composes();
}

TEST(SegmentChain, SeveralReturnBetweenSegments) {
  Walk walk(2);
  for (int i = 0; i < 40; ++i) walk.step(i % 2 == 0 ? 3 : 0, i % 4);
  walk.expect_recalls();
  walk.expect_composes();
}

// They pass through all segments, and composed segments begin with them.
TEST(SegmentChain, ItsBytesAreBoundedWhereLandmarksOfAllSegmentsReturn) {
  constexpr std::size_t kSpare = 300'000;
  Walk walk(5, kSpare);
  for (int i = 0; i < 12; ++i) walk.step(5, 0);
  for (int i = 0; i < 120; ++i) {
    walk.step(5, 5);
    if (i % 10 == 0) walk.expect_recalls();
  }
  walk.expect_composes();
}

// More than one segment may have.
TEST(SegmentChain, ManyItemsStayInSeveralSegments) {
  Walk walk(3);
  for (int i = 0; i < 50; ++i) walk.step(12, i % 7 == 6 ? 3 : 0);
  ASSERT_GT(3 * walk.landmarks(), SegmentChain::kMostVariables);
  walk.expect_recalls();
  walk.expect_composes();
}

TEST(SegmentChain, TheOldestLandmarksAreDiscarded) {
  Walk walk(4);
  for (int i = 0; i < 30; ++i) {
    walk.step(3, i % 4);
    walk.discard(2 * i);
    walk.expect_recalls();
  }
  walk.expect_composes();
}

}  // namespace
}  // namespace chasles
