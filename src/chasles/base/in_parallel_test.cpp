#include <atomic>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/base/in_parallel.hpp>

namespace chasles::test {
namespace {

TEST(InParallel, DoesEachOnce) {
  for (const int threads : {1, 2, 7}) {
    std::vector<std::atomic<int>> done(100);
    in_parallel(done.size(), threads, [&](std::size_t i) { ++done[i]; });
    for (const std::atomic<int>& times : done) EXPECT_EQ(times, 1);
  }
  in_parallel(0, 4, [](std::size_t) { FAIL(); });
}

TEST(InParallel, ThrowsWhatTheLowestThrew) {
  for (const int threads : {1, 2}) {
    std::atomic<int> started = 0;
    try {
      in_parallel(1000, threads, [&](std::size_t i) {
        ++started;
        throw std::runtime_error(std::to_string(i));
      });
      FAIL();
    } catch (const std::runtime_error& error) {
      EXPECT_STREQ(error.what(), "0");
    }
    EXPECT_LE(started, threads);
  }
}

TEST(InParallel, AnInterruptionReachesAllThreads) {
  CallProgress progress;
  progress.stop = true;
  const ObservedCall observed(progress);
  EXPECT_THROW(in_parallel(2, 2,
                           [&](std::size_t i) {
                             if (i == 1) interruption_point();
                           }),
               Interrupted);
}

}  // namespace
}  // namespace chasles::test
