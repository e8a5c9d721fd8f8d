#include <gtest/gtest.h>

#include <chasles/eval/chi2.hpp>
#include <chasles/eval/nees.hpp>
#include <chasles/imu/imu_correction_testing.hpp>
#include <chasles/lie/testing.hpp>
#include <chasles/pipeline/run.hpp>
#include <chasles/slam/calibration_testing.hpp>
#include <chasles/smooth/batch/batch_terms.hpp>

// The IMU's parameters in batch and window, from a standstill on.
namespace chasles {
namespace {

// At the standstill a g-sensitivity hides in the bias of the gyroscope, and scales in tilt and
// bias: the start is correlated with them, and the one of the later part with what the first one
// found. For given parameters the start's bias is as certain as the standstill makes it.
TEST(RunWithAnImuInTheState, BeginsAtAStandstillAndOutlastsAGap) {
  constexpr std::uint64_t kRuns = 2;
  InertialScene scene = test::shaken(1);
  scene.settings.rest_duration = 3;
  scene.settings.start_duration = 1;
  scene.settings.sections = 2;
  InertialRunSettings settings;
  settings.filter.calibrate_imu = Calibrate::kTrue;
  settings.filter.initial_g_sensitivity_sigma = 0.001;
  for (const char* estimator : {"batch", "window:10"}) {
    settings.estimator = estimator_choice(estimator);
    double parameters = 0, biases = 0;
    for (std::uint64_t run = 0; run < kRuns; ++run) {
      ImuCorrection errors;
      const Eigen::VectorXd sigmas = imu_sigmas(settings.filter, errors);
      test::Random random(40 + run);
      errors.set(sigmas.cwiseProduct(random.normal_vector(sigmas.size())));
      Recording recording = simulate_inertial(scene, run);
      for (ImuSample& sample : recording.imu) sample = test::as_measured(errors, sample);
      test::remove_samples(recording, 10, 10.7);
      const RunResult result = chasles::run(recording, settings);
      if (!result.report.estimator.batch_terms.empty()) {
        const Matrix15d& P = result.report.estimator.batch_terms.front()->start_covariance;
        EXPECT_LT(P.diagonal().tail<3>().maxCoeff(), 1e-6);
      }
      const Estimate& last = result.estimates.back();
      ASSERT_TRUE(last.calibration && last.calibration->imu) << estimator;
      const Calibration& found = *last.calibration;
      parameters += normalised_square(errors.parameters() - found.imu->parameters(),
                                      found.covariance.bottomRightCorner(24, 24));
      const auto truth = true_motion_at(recording, last.time);
      biases += normalised_square(truth->gyroscope_bias - last.additive.tail<3>(),
                                  last.covariance.bottomRightCorner<3, 3>());
    }
    EXPECT_LT(parameters / 24 / kRuns, 1.5) << estimator;
    EXPECT_LT(biases, chi2_quantile(0.9995, 3 * kRuns)) << estimator;
  }
}

}  // namespace
}  // namespace chasles
