#include <gtest/gtest.h>

#include <chasles/eval/chi2.hpp>
#include <chasles/lab/loops.hpp>

namespace chasles {
namespace {

constexpr int kRuns = 40;

struct Means {
  double orientation = 0, pose = 0, square = 0;  // NEES per degree of freedom; [m^2]
};

Means means(const char* chart, double sigma) {
  LoopsSettings settings;
  settings.sigma = sigma;
  Means result;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Trial trial = run_loops(settings, chart, run);
    EXPECT_FALSE(trial.diverged) << chart << " run " << run;
    const TrialAverages a = averages(trial);
    result.orientation += a.nees_attitude / 3 / kRuns;
    result.pose += a.nees_pose / 6 / kRuns;
    result.square += a.position_rms * a.position_rms / kRuns;
  }
  return result;
}

// Zhang et al. 2017, Table II: 1.0 and 1.01 with the landmarks in the group, 3.7 and 3.1 in SO(3) x
// R3.
TEST(Loops, WithLargeNoiseOnlyTheGroupIsConsistent) {
  const Means group = means("right-sen3", 0.05);
  const Means standard = means("standard", 0.05);
  EXPECT_GT(group.pose, 0.85);
  EXPECT_LT(group.pose, 1.2);
  EXPECT_LT(group.orientation, 1.2);
  EXPECT_GT(standard.pose, 1.3);
  EXPECT_GT(standard.orientation, 1.4);
  EXPECT_LT(group.square, standard.square);
}

// 1.02 and 1.01 against 1.34 and 1.35.
TEST(Loops, WithSmallNoiseAllAreNearlyConsistent) {
  const Means group = means("right-sen3", 0.01);
  EXPECT_GT(group.pose, 0.85);
  EXPECT_LT(group.pose, 1.15);
  EXPECT_LT(means("standard", 0.01).pose, 1.5);
}

TEST(Loops, TheNoiseIsTheSameForEveryChartAndAnotherForEveryRun) {
  const LoopsSettings settings{.steps = 40, .loops = 1};
  const Trial a = run_loops(settings, "standard", 3);
  const Trial b = run_loops(settings, "right-sen3", 3);
  const Trial c = run_loops(settings, "standard", 4);
  EXPECT_NEAR(a.points[2].position_error, b.points[2].position_error, 1e-3);
  EXPECT_GT(std::abs(a.points[2].position_error - c.points[2].position_error), 1e-4);
  EXPECT_EQ(a.points[20].position_error,
            run_loops(settings, "standard", 3).points[20].position_error);
}

}  // namespace
}  // namespace chasles
