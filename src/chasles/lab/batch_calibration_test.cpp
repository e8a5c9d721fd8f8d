#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/filter/testing.hpp>
#include <chasles/lab/batch_trial.hpp>
#include <chasles/pipeline/run.hpp>
#include <chasles/slam/calibration_testing.hpp>

// Batch estimation of extrinsics and time offset on simulated recordings with known calibration,
// from the filter's estimates, as a run has it.
namespace chasles {
namespace {

using test::after;
using test::calibrating;
using test::calibration_error;
using test::drawn;
using test::is_chi2;
using test::Miscalibrated;
using test::miscalibrated;
using test::remove_samples;
using test::shaken;
using test::simulate_densely;

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

// A later part begins with what the earlier ones know of the calibration.
TEST(CalibratingOverAGap, KeepsTheCalibration) {
  InertialScene scene = shaken(1);
  scene.settings.sections = 2;
  scene.settings.roll_amplitude = scene.settings.pitch_amplitude = scene.settings.yaw_amplitude =
      0.03;
  const InertialSlamSettings settings = calibrating();
  const Recording right = simulate_densely(scene, 0);
  Eigen::VectorXd errors(7);
  errors << 0.02, -0.02, 0.02, 0.017, -0.017, 0.017, 0.004;
  Miscalibrated m = miscalibrated(right, errors, draw_start(right, settings, 1, 0));
  remove_samples(m.recording, 6, 6.7);
  for (const char* estimator : {"batch", "window:10"}) {
    InertialRunSettings of_run;
    of_run.estimator = estimator_choice(estimator);
    of_run.filter = settings;
    const RunResult result = run(m.recording, of_run);
    const Estimate* before = nullptr;
    const Estimate* anew = nullptr;
    for (const Estimate& e : result.estimates) {
      ASSERT_TRUE(e.calibration) << estimator;
      if (e.time < after(m.recording, 6)) before = &e;
      if (!anew && e.time > after(m.recording, 6.7)) anew = &e;
    }
    ASSERT_TRUE(before && anew) << estimator;
    const Eigen::VectorXd known = before->calibration->covariance.diagonal();
    const Eigen::VectorXd kept = anew->calibration->covariance.diagonal();
    EXPECT_LT(kept.cwiseQuotient(known).maxCoeff(), 1.1) << estimator;
    const Calibration& found = *result.estimates.back().calibration;
    const Eigen::VectorXd error = calibration_error(m.truth, found);
    const Eigen::VectorXd sigma = found.covariance.diagonal().cwiseSqrt();
    EXPECT_LT(error.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 4) << estimator;
    EXPECT_LT(error.head<3>().norm(), 0.01) << estimator;
    EXPECT_LT(std::abs(error[6]), 1e-3) << estimator;
  }
}

}  // namespace
}  // namespace chasles
