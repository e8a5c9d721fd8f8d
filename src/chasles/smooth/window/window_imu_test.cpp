#include <gtest/gtest.h>

#include <chasles/filter/testing.hpp>
#include <chasles/smooth/batch/calibration_scene_testing.hpp>
#include <chasles/smooth/batch/exact_settings_testing.hpp>
#include <chasles/smooth/terms/calibration_blocks_detail.hpp>
#include <chasles/smooth/window/inertial_window.hpp>

// The IMU's parameters as a state of the window.
namespace chasles {
namespace {

using namespace test;

struct Ends {
  Estimate window, batch;

  Eigen::VectorXd apart() const {  // in the batch's sigmas
    const Eigen::VectorXd sigma = batch.calibration->covariance.diagonal().cwiseSqrt();
    return smooth_detail::calibration_difference(*window.calibration, *batch.calibration)
        .cwiseQuotient(sigma);
  }
};

Ends ends(const CalibrationScene& scene, LandmarkForm form, int keyframes) {
  BatchSettings settings = exact_settings(form);
  settings.min_parallax = 0;
  return {slide(scene.input, "right-sen3", settings, keyframes).estimates.back(),
          smooth(scene.input, "right-sen3", settings).estimates.back()};
}

// A window that holds everything is the batch; with all of the cameras, too.
TEST(WindowImu, OfAllKeyframesIsThatOfTheBatch) {
  for (const LandmarkForm form : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    for (const bool cameras : {false, true}) {
      const SmallFlight flight{.frames = 10, .noise = 0.1, .landmarks = 40, .seed = 3};
      CalibrationScene scene =
          cameras ? calibration_scene(flight, 0.02, 0.1) : imu_scene(flight, 0.1);
      if (cameras) measure_wrongly(scene, flight.seed, 0.1);
      const Ends at = ends(scene, form, 20);
      EXPECT_LT(at.apart().cwiseAbs().maxCoeff(), 0.02) << cameras;
      EXPECT_LT(covariance_difference(at.window.calibration->covariance,
                                      at.batch.calibration->covariance),
                0.05);
      EXPECT_LT(covariance_difference(at.window.covariance, at.batch.covariance), 0.05);
    }
  }
}

// Nor do its values move where it is considered.
TEST(WindowImu, IsConsideredAsByTheBatch) {
  CalibrationScene scene =
      imu_scene({.frames = 24, .noise = 0.01, .landmarks = 40, .seed = 4}, 0.01);
  scene.consider_all();
  BatchSettings settings = exact_settings(LandmarkForm::kInverseDepth);
  settings.min_parallax = 0;
  settings.loops = false;
  const Estimate window = slide(scene.input, "right-sen3", settings, 6).estimates.back();
  const Estimate batch = smooth(scene.input, "right-sen3", settings).estimates.back();
  EXPECT_EQ(window.calibration->imu->parameters(), scene.input.calibration->imu->parameters());
  EXPECT_LT(covariance_difference(window.covariance, batch.covariance), 0.02);
  EXPECT_LT(covariance_difference(window.calibration->covariance, batch.calibration->covariance),
            0.02);
}

// With hardly any noise the problem is linear: it knows no more than the batch, and hardly less.
TEST(WindowImu, OfFewKeyframesIsNearThatOfTheBatch) {
  for (const LandmarkForm form : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    const CalibrationScene scene =
        imu_scene({.frames = 24, .noise = 0.01, .landmarks = 40, .seed = 4}, 0.01);
    const Ends at = ends(scene, form, 6);
    EXPECT_LT(at.apart().cwiseAbs().maxCoeff(), 0.2) << name_of(form);
    const Eigen::VectorXd more = at.window.calibration->covariance.diagonal().cwiseQuotient(
        at.batch.calibration->covariance.diagonal());
    EXPECT_GT(more.minCoeff(), 0.99) << name_of(form);
    EXPECT_LT(more.maxCoeff(), 1.5) << name_of(form);
  }
}

TEST(WindowImu, IsWrongByAsMuchAsItSays) {
  double calibrations = 0, states = 0;
  int dof = 0, runs = 0;
  for (; runs < 16; ++runs) {
    const auto seed = 600 + static_cast<std::uint64_t>(runs);
    const CalibrationScene scene =
        imu_scene({.frames = 20, .cameras = 1 + runs % 2, .landmarks = 40, .seed = seed});
    BatchSettings settings = without_outliers();
    settings.window_steps = 3;
    const auto last = slide(scene.input, "right-sen3", settings, 6).estimates.back();
    const Eigen::VectorXd e =
        smooth_detail::calibration_difference(scene.true_calibration, *last.calibration);
    calibrations += squared_error(e, last.calibration->covariance);
    dof += static_cast<int>(e.size());
    states += squared_error(motion_error(scene.motion_at(last.time), last), last.covariance);
  }
  EXPECT_TRUE(is_chi2(calibrations, dof));
  EXPECT_TRUE(is_chi2(states, 15 * runs));
}

}  // namespace
}  // namespace chasles
