#include <vector>

#include <chasles/filter/past/condensed_run.hpp>
#include <chasles/filter/past/temporary_folder_testing.hpp>
#include <chasles/filter/random_ekf_testing.hpp>

// What is on disk, against the same in memory; past_test.cpp has the estimates themselves.

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

constexpr std::size_t kAllInMemory = 1 << 30;
constexpr int kSegments = 3;

// A run of a state with eight rows, from which a landmark and a pose leave in each segment.
class RandomRun {
 public:
  explicit RandomRun(std::size_t bytes_in_memory) : run_(kSegments, bytes_in_memory) {}

  void append(int segments) {
    for (int i = 0; i < segments; ++i)
      run_.append(segment(), test::random_covariance(random_, 8, 1));
  }

  CondensedRun& run() { return run_; }
  const CondensedRun& run() const { return run_; }

  std::vector<SmoothedState> states() const {
    RandomRun other = *this;
    std::vector<SmoothedState> all;
    run_.visit(other.segment(), [&](const SmoothedState& one) { all.push_back(one); });
    return all;
  }

 private:
  Segment segment() {
    constexpr Index kStarts = 8, kVariables = kStarts + 9;
    Segment next;
    next.starts = kStarts;
    next.items = {{.number = number_, .size = 3}, {.number = number_ + 1, .size = 6}};
    number_ += 2;
    next.X = 0.3 * test::random_matrix(random_, kStarts, kVariables);
    next.G = test::random_covariance(random_, static_cast<int>(kVariables), 1);
    next.g = random_.normal_vector(kVariables);
    return next;
  }

  test::Random random_{12};
  int number_ = 0;
  CondensedRun run_;
};

void expect_same_bytes(const std::vector<SmoothedState>& a, const std::vector<SmoothedState>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    ASSERT_EQ(a[i].number, b[i].number);
    EXPECT_EQ(a[i].correction, b[i].correction);
    EXPECT_EQ(a[i].covariance, b[i].covariance);
  }
}

RandomRun after(int segments, std::size_t bytes_in_memory) {
  RandomRun result(bytes_in_memory);
  result.append(segments);
  return result;
}

TEST(CondensedRun, TheEstimatesFromDiskAreTheSameBytes) {
  const RandomRun memory = after(40, kAllInMemory), disk = after(40, 0), some = after(40, 20'000);
  EXPECT_EQ(memory.run().bytes_on_disk(), 0u);
  EXPECT_GT(some.run().bytes_on_disk(), 0u);
  EXPECT_GT(disk.run().bytes_on_disk(), some.run().bytes_on_disk());
  EXPECT_EQ(disk.run().bytes(), memory.run().bytes());
  ASSERT_EQ(memory.states().size(), 82u);
  expect_same_bytes(disk.states(), memory.states());
  expect_same_bytes(some.states(), memory.states());
}

// Beyond the bound memory grows by what connects a batch with the next one: two 8x8 matrices.
TEST(CondensedRun, KeepsABoundInMemory) {
  constexpr std::size_t kBound = 40'000, kBatches = 40, kConnection = 2 * 8 * 8 * sizeof(double);
  RandomRun run(kBound);
  const auto in_memory = [&] { return run.run().bytes() - run.run().bytes_on_disk(); };
  run.append(100);
  EXPECT_GT(run.run().bytes_on_disk(), 0u);
  const std::size_t before = in_memory(), all_before = run.run().bytes();
  run.append(static_cast<int>(kBatches) * kSegments);
  EXPECT_LE(in_memory(), before + kBatches * kConnection);
  EXPECT_GT(run.run().bytes(), all_before + 2 * kBatches * kConnection);
}

TEST(CondensedRun, CopiesThatPartHaveStatesOfTheirOwn) {
  RandomRun one = after(20, 0), other = one;
  other.run().give_up_older_half([](const SmoothedState&) {});
  other.append(15);
  one.append(20);
  expect_same_bytes(one.states(), after(40, kAllInMemory).states());
  RandomRun expected = after(20, kAllInMemory);
  expected.run().give_up_older_half([](const SmoothedState&) {});
  expected.append(15);
  expect_same_bytes(other.states(), expected.states());
}

TEST(CondensedRun, WithoutAFolderAllOfItStaysInMemory) {
  const test::TemporaryFolder nowhere("/proc/sys");
  const RandomRun run = after(40, 0);
  EXPECT_EQ(run.run().bytes_on_disk(), 0u);
  expect_same_bytes(run.states(), after(40, kAllInMemory).states());
}

}  // namespace
}  // namespace chasles
