#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/filter/testing.hpp>
#include <chasles/smooth/batch/calibration_scene_testing.hpp>
#include <chasles/smooth/batch/exact_settings_testing.hpp>
#include <chasles/smooth/terms/calibration_blocks_detail.hpp>
#include <chasles/smooth/window/inertial_window.hpp>

// The calibration as a state of the window.
namespace chasles {
namespace {

using namespace test;

double normalised(const Eigen::VectorXd& e, const Eigen::MatrixXd& P) {
  return e.dot(P.ldlt().solve(e));
}

// A window that holds everything is the batch.
TEST(WindowCalibration, OfAllKeyframesIsThatOfTheBatch) {
  for (const LandmarkForm form : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    for (const int cameras : {1, 2}) {
      const CalibrationScene scene = calibration_scene(
          {.frames = 10, .cameras = cameras, .noise = 0.1, .landmarks = 40, .seed = 3}, 0.02, 0.1);
      BatchSettings settings = exact_settings(form);
      settings.min_parallax = 0;
      const auto window = slide(scene.input, "right-sen3", settings, 20).estimates.back();
      const auto batch = smooth(scene.input, "right-sen3", settings).estimates.back();
      ASSERT_TRUE(window.calibration && batch.calibration);
      const Eigen::VectorXd sigma = batch.calibration->covariance.diagonal().cwiseSqrt();
      const Eigen::VectorXd apart =
          smooth_detail::calibration_difference(*window.calibration, *batch.calibration);
      EXPECT_LT(apart.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 0.02) << cameras;
      EXPECT_LT(
          covariance_difference(window.calibration->covariance, batch.calibration->covariance),
          0.05);
      EXPECT_LT(covariance_difference(window.covariance, batch.covariance), 0.05);
    }
  }
}

// With hardly any noise the problem is linear: it knows no more than the batch, and hardly less.
TEST(WindowCalibration, OfFewKeyframesIsNearThatOfTheBatch) {
  for (const LandmarkForm form : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    CalibrationScene scene =
        calibration_scene({.frames = 24, .noise = 0.01, .landmarks = 40, .seed = 4}, 0.02, 0.01);
    BatchSettings settings = exact_settings(form);
    settings.min_parallax = 0;
    const auto window = slide(scene.input, "right-sen3", settings, 6).estimates.back();
    const auto batch = smooth(scene.input, "right-sen3", settings).estimates.back();
    const Eigen::VectorXd sigma = batch.calibration->covariance.diagonal().cwiseSqrt();
    const Eigen::VectorXd apart =
        smooth_detail::calibration_difference(*window.calibration, *batch.calibration);
    EXPECT_LT(apart.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 0.2) << name_of(form);
    const Eigen::VectorXd more =
        window.calibration->covariance.diagonal().cwiseQuotient(sigma.cwiseAbs2());
    EXPECT_GT(more.minCoeff(), 0.99) << name_of(form);
    EXPECT_LT(more.maxCoeff(), 1.5) << name_of(form);
  }
}

// Hardly any rotation: what was not observed stays unknown, however depths and poses change while
// keyframes leave.
TEST(WindowCalibration, OfWhatTheMotionDoesNotShowIsNotKnown) {
  for (const int cameras : {1, 2}) {
    CalibrationScene scene = calibration_scene(
        {.frames = 40, .cameras = cameras, .turning = 0.1, .landmarks = 40, .seed = 4}, 0);
    InertialSlamSettings settings;
    settings.calibrate_extrinsics = Calibrate::kTrue;
    scene.input.calibration = stated_calibration(settings, scene.input.cameras);
    BatchSettings exact = exact_settings(LandmarkForm::kInverseDepth);
    exact.min_parallax = 0;
    const auto window = slide(scene.input, "right-sen3", exact, 8).estimates.back();
    const auto batch = smooth(scene.input, "right-sen3", exact).estimates.back();
    const Eigen::VectorXd ratio = window.calibration->covariance.diagonal().cwiseQuotient(
        batch.calibration->covariance.diagonal());
    EXPECT_GT(ratio.minCoeff(), 0.93) << cameras << ": " << ratio.transpose();
    EXPECT_LT(ratio.maxCoeff(), 1.15) << cameras << ": " << ratio.transpose();
  }
}

TEST(WindowCalibration, IsWrongByAsMuchAsItSays) {
  for (const double readout : {0.0, 0.02}) {
    double calibrations = 0, states = 0;
    int dof = 0, runs = 0;
    for (; runs < 16; ++runs) {
      const auto seed = 600 + static_cast<std::uint64_t>(runs);
      const CalibrationScene scene =
          calibration_scene({.frames = 20, .landmarks = 40, .seed = seed}, readout);
      BatchSettings settings;
      settings.loss = BatchLoss::kNone;
      settings.gate = 0;
      settings.covariance_factor = 1;
      settings.window_steps = 3;
      const auto last = slide(scene.input, "right-sen3", settings, 6).estimates.back();
      const Eigen::VectorXd e =
          smooth_detail::calibration_difference(scene.true_calibration, *last.calibration);
      calibrations += normalised(e, last.calibration->covariance);
      dof += static_cast<int>(e.size()) - scene.empty_rows;
      states += normalised(motion_error(scene.motion_at(last.time), last), last.covariance);
    }
    EXPECT_TRUE(is_chi2(calibrations, dof)) << readout;
    EXPECT_TRUE(is_chi2(states, 15 * runs)) << readout;
  }
}

TEST(WindowCalibration, IsNotConsidered) {
  CalibrationScene scene = calibration_scene({.frames = 6, .seed = 5}, 0);
  scene.input.considered = {1, 2};
  try {
    slide(scene.input, "right-sen3", {}, 5);
    FAIL() << "expected an error";
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("found 2 considered rows"), std::string::npos);
  }
}

}  // namespace
}  // namespace chasles
