#include <algorithm>
#include <cmath>
#include <optional>
#include <set>

#include <chasles/filter/past/segment_chain.hpp>
#include <chasles/filter/random_ekf_testing.hpp>

// A chain of segments against one segment that has all items and all their cross-covariances.

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

class AllItems {
 public:
  void append(const Segment& segment) { all_ = all_ ? compose(*all_, segment) : segment; }
  Carried recall(const std::vector<int>& numbers) const {
    Carried past;
    carry(past, *all_, numbers);
    return past;
  }
  Carried revive(const std::vector<int>& numbers) {
    Carried past = recall(numbers);
    take_along(*all_, numbers);
    return past;
  }
  Index rows() const { return all_ ? all_->X.rows() : 0; }

 private:
  std::optional<Segment> all_;
};

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
  explicit Walk(int seed) : random_(seed) {}

  void step(int leaving, int returning) {
    const Index n = all_items_.rows(), end = 6 + static_cast<Index>(random_.next() % 4);
    Segment segment;
    segment.starts = n;
    for (int i = 0; i < leaving; ++i) {
      segment.items.push_back({.number = next_, .size = 3});
      there_.insert(next_++);
    }
    const Index q = n + 3 * leaving;
    // So that nothing grows without bounds.
    segment.X = test::random_matrix(random_, end, q) / std::sqrt(static_cast<double>(q));
    segment.G = test::random_covariance(random_, static_cast<int>(q), 1) / static_cast<double>(q);
    segment.g = random_.normal_vector(q);
    all_items_.append(segment);
    chain_.append(segment, [&](int number) { return there_.contains(number); });
    const std::vector<int> numbers = some(returning);
    for (const int number : numbers) there_.erase(number);
    if (!numbers.empty()) expect_equal(chain_.revive(numbers), all_items_.revive(numbers));
  }
  void expect_recalls() const {
    const std::vector<int> all(there_.begin(), there_.end());
    expect_equal(chain_.recall(all), all_items_.recall(all));
  }
  void expect_composes() const {
    const std::vector<int> all(there_.begin(), there_.end());
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
  std::vector<int> some(int count) {
    std::set<int> chosen;
    const std::vector<int> all(there_.begin(), there_.end());
    for (int i = 0; i < count && !all.empty(); ++i) chosen.insert(all[random_.next() % all.size()]);
    return {chosen.begin(), chosen.end()};
  }

  test::Random random_;
  AllItems all_items_;
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
