#include <gtest/gtest.h>

#include <chasles/filter/testing.hpp>
#include <chasles/lab/batch_trial.hpp>
#include <chasles/slam/inertial_session_testing.hpp>

namespace chasles {
namespace {

InertialScene quick_turntable() {
  InertialScene scene = test::short_turntable();
  scene.settings.revolutions = 0.3;
  return scene;
}

class BatchTrials : public test::OverCharts {
 protected:
  FilterVariant variant() const {
    FilterVariant filter{.name = "any", .settings = {}};
    filter.settings.chart = chart().name;
    return filter;
  }
};

// Kleinert & Stilla's turntable, shorter: the batch is more accurate than the filter, and its
// covariance is consistent.
TEST_P(BatchTrials, ErrLessThanTheFilterAndKnowHowMuch) {
  const InertialScene scene = quick_turntable();
  double of_filter = 0, of_batch = 0, pose = 0, state = 0;
  constexpr int kRuns = 4;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Recording recording = simulate_inertial(scene, run);
    const InertialStart start = draw_start(recording, variant().settings, scene.settings.seed, run);
    of_filter += averages(run_trial(variant(), recording, start)).ate_posyaw;
    BatchSettings settings;
    settings.loss = BatchLoss::kNone;  // without outliers its covariance is exact
    const BatchTrial batch = run_batch_trial(variant(), settings, recording, start,
                                             filter_motions(variant(), recording, start));
    EXPECT_TRUE(batch.report.converged) << batch.report.end;
    EXPECT_TRUE(batch.report.unobservable.empty());
    EXPECT_NEAR(batch.report.cost_per_dof, 1, 0.05);
    of_batch += averages(batch.trial).ate_posyaw;
    const TrialPoint& middle = batch.trial.points[batch.trial.points.size() / 2];
    pose += middle.nees_pose;
    state += middle.nees_state;
  }
  EXPECT_LT(of_batch, 0.7 * of_filter);
  EXPECT_TRUE(test::is_chi2(pose, 6 * kRuns));
  EXPECT_TRUE(test::is_chi2(state, 15 * kRuns));
}

INSTANTIATE_TEST_SUITE_P(Charts, BatchTrials, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

TEST(BatchTrialCharts, EndInTheSameMinimum) {
  const InertialScene scene = quick_turntable();
  const Recording recording = simulate_inertial(scene, 3);
  std::vector<double> costs;
  Trajectory first;
  for (const ErrorChart* chart : test::all_charts()) {
    FilterVariant filter{.name = "any", .settings = {}};
    filter.settings.chart = chart->name;
    const InertialStart start = draw_start(recording, filter.settings, scene.settings.seed, 3);
    BatchSettings settings;
    settings.tolerance = 1e-12;
    const BatchTrial batch = run_batch_trial(filter, settings, recording, start,
                                             filter_motions(filter, recording, start));
    costs.push_back(batch.report.final_cost);
    if (first.empty()) first = batch.trial.estimate;
    EXPECT_NEAR(costs.back() / costs.front(), 1, 1e-9) << chart->name;
    for (std::size_t k = 0; k < first.size(); ++k) {
      ASSERT_LT((batch.trial.estimate[k].pose.p - first[k].pose.p).norm(), 1e-4) << chart->name;
    }
  }
}

// During the search, points pass close in front of the cameras. This search ends elsewhere if they
// may come as near as at the solution. studies/convergence.md has the rate of success of such
// searches.
TEST(BatchTrial, FindsItsWayBackFromAFifthOff) {
  InertialScene scene = test::short_hallway();
  scene.settings.sections = 1;
  const Recording recording = simulate_inertial(scene, 0);
  const FilterVariant filter{.name = "any", .settings = {}};
  const InertialStart start = draw_start(recording, filter.settings, scene.settings.seed, 0);
  const std::vector<TimedMotion> initial = filter_motions(filter, recording, start);
  BatchSettings settings;
  settings.loss = BatchLoss::kNone;
  settings.gate = 0;
  const BatchReport near = run_batch_trial(filter, settings, recording, start, initial).report;
  settings.initial_error = 0.2;
  settings.seed = 4;
  const BatchReport far = run_batch_trial(filter, settings, recording, start, initial).report;
  EXPECT_GT(far.initial_cost, 1e4 * far.final_cost);
  EXPECT_NEAR(far.final_cost / near.final_cost, 1, 1e-6);
  EXPECT_TRUE(far.converged);
  EXPECT_FALSE(far.stalled);
}

TEST(BatchTrial, TheCalibrationOfTheSettingsIsEstimated) {
  const Recording recording = simulate_inertial(quick_turntable(), 0);
  InertialSlamSettings settings;
  const InertialStart start = draw_start(recording, settings, 1, 0);
  EXPECT_FALSE(batch_input(recording, settings, start).calibration);
  settings.calibrate_extrinsics = Calibrate::kTrue;
  settings.calibrate_intrinsics = Calibrate::kConsidered;
  const InertialBatchInput input = batch_input(recording, settings, start);
  ASSERT_TRUE(input.calibration);
  EXPECT_EQ(input.calibration->imu_T_camera.size(), recording.cameras.size());
  ASSERT_FALSE(input.considered.empty());
  EXPECT_EQ(input.considered.front(), 6 * static_cast<int>(recording.cameras.size()));
}

}  // namespace
}  // namespace chasles
