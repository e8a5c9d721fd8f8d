#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/filter/testing.hpp>
#include <chasles/lab/batch_trial.hpp>
#include <chasles/slam/calibration_testing.hpp>

// Batch estimation of extrinsics and time offset on simulated recordings with known calibration,
// from the filter's estimates, as a run has it.
namespace chasles {
namespace {

using namespace test;

TEST(BatchCalibrating, IsWrongByAsMuchAsItSaysAndAgreesWithTheFilter) {
  const InertialSlamSettings settings = calibrating();
  const FilterVariant filter{.name = "any", .settings = settings};
  BatchSettings exact;
  exact.loss = BatchLoss::kNone;  // without outliers its covariance is exact
  exact.covariance_factor = 1;
  double calibration = 0, pose = 0;
  constexpr int kRuns = 4;
  for (std::uint64_t run = 0; run < kRuns; ++run) {
    const Miscalibrated m = drawn(shaken(1), settings, run);
    std::vector<TimedMotion> motions;
    std::optional<Calibration> of_filter;
    run_filter(filter, m.recording, m.start, [&](const Estimate& e) {
      motions.push_back(timed_motion(e, Time{}));
      of_filter = e.calibration;
      return true;
    });
    const BatchTrial batch =
        run_batch_trial(filter, exact, m.recording, m.start, std::move(motions));
    EXPECT_TRUE(batch.report.converged) << batch.report.end;
    ASSERT_TRUE(batch.trial.calibration && of_filter);
    const Calibration& found = *batch.trial.calibration;
    const Eigen::VectorXd error = calibration_error(m.truth, found);
    const Eigen::VectorXd sigma = found.covariance.diagonal().cwiseSqrt();
    EXPECT_LT(error.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 3.5) << run;
    calibration += normalised_square(error, found.covariance);
    pose += batch.trial.points[batch.trial.points.size() / 2].nees_pose;
    // Both are estimates of the same from nearly the same data.
    const Eigen::VectorXd apart = calibration_error(found, *of_filter);
    const Eigen::VectorXd wide = of_filter->covariance.diagonal().cwiseSqrt();
    EXPECT_LT(apart.cwiseQuotient(wide).cwiseAbs().maxCoeff(), 4) << run;
    EXPECT_LT(sigma.cwiseQuotient(wide).maxCoeff(), 1.1) << run;
  }
  EXPECT_TRUE(is_chi2(calibration, 7 * kRuns));
  EXPECT_TRUE(is_chi2(pose, 6 * kRuns));
}

}  // namespace
}  // namespace chasles
