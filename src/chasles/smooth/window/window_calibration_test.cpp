#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/filter/testing.hpp>
#include <chasles/smooth/batch/calibration_scene_testing.hpp>
#include <chasles/smooth/batch/exact_settings_testing.hpp>
#include <chasles/smooth/batch/problem_blocks_detail.hpp>
#include <chasles/smooth/terms/calibration_blocks_detail.hpp>
#include <chasles/smooth/window/inertial_window.hpp>

// The calibration as a state of the window.
namespace chasles {
namespace {

using namespace test;

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
      BatchSettings settings = without_outliers();
      settings.window_steps = 3;
      const auto last = slide(scene.input, "right-sen3", settings, 6).estimates.back();
      const Eigen::VectorXd e =
          smooth_detail::calibration_difference(scene.true_calibration, *last.calibration);
      calibrations += squared_error(e, last.calibration->covariance);
      dof += static_cast<int>(e.size()) - scene.empty_rows;
      states += squared_error(motion_error(scene.motion_at(last.time), last), last.covariance);
    }
    EXPECT_TRUE(is_chi2(calibrations, dof)) << readout;
    EXPECT_TRUE(is_chi2(states, 15 * runs)) << readout;
  }
}

std::vector<int> all_rows(const CalibrationScene& scene) {
  return smooth_detail::range(0, static_cast<int>(scene.input.calibration->covariance.rows()));
}

// All of it, and the extrinsics alone.
std::vector<std::vector<int>> considered_cases(const CalibrationScene& scene) {
  const auto cameras = static_cast<int>(scene.input.cameras.size());
  return {all_rows(scene), smooth_detail::range(0, 6 * cameras)};
}

// The difference in sigmas of the second one.
Eigen::VectorXd apart(const Estimate& one, const Estimate& other) {
  const Eigen::VectorXd e = motion_error({.world_T_imu = other.world_T_imu,
                                          .v_world = *other.v_world,
                                          .accelerometer_bias = other.additive.head<3>(),
                                          .gyroscope_bias = other.additive.tail<3>()},
                                         one);
  return e.cwiseQuotient(other.covariance.diagonal().cwiseSqrt());
}

TEST(WindowCalibration, OfAllKeyframesIsConsideredAsByTheBatch) {
  for (const LandmarkForm form : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    for (const int cameras : {1, 2}) {
      CalibrationScene scene = calibration_scene(
          {.frames = 10, .cameras = cameras, .noise = 0.1, .landmarks = 40, .seed = 3}, 0.02, 0.1);
      BatchSettings settings = exact_settings(form);
      settings.min_parallax = 0;
      for (const std::vector<int>& considered : considered_cases(scene)) {
        scene.input.considered = considered;
        const auto window = slide(scene.input, "right-sen3", settings, 20);
        const auto batch = smooth(scene.input, "right-sen3", settings);
        const Estimate &last = window.estimates.back(), &same = batch.estimates.back();
        // Biases move preintegrated samples only to first order.
        EXPECT_LT(apart(last, same).cwiseAbs().maxCoeff(), 0.06);
        EXPECT_LT(covariance_difference(last.covariance, same.covariance), 0.05);
        EXPECT_LT(covariance_difference(last.calibration->covariance, same.calibration->covariance),
                  0.05);
        ASSERT_EQ(window.landmarks.size(), batch.landmarks.size());
        for (std::size_t i = 0; i < batch.landmarks.size(); ++i) {
          const auto same =
              std::ranges::find(window.landmarks, batch.landmarks[i].id, &MapLandmark::id);
          ASSERT_NE(same, window.landmarks.end());
          EXPECT_LT(covariance_difference(same->covariance, batch.landmarks[i].covariance), 0.05);
        }
      }
    }
  }
}

// What leaves the window takes nothing of the calibration with it: of the same tracks, it has the
// batch's covariance.
TEST(WindowCalibration, OfFewKeyframesIsConsideredAsByTheBatch) {
  for (const LandmarkForm form : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    CalibrationScene scene =
        calibration_scene({.frames = 24, .noise = 0.01, .landmarks = 40, .seed = 4}, 0.02, 0.01);
    BatchSettings settings = exact_settings(form);
    settings.min_parallax = 0;
    settings.loops = false;
    for (const std::vector<int>& considered : considered_cases(scene)) {
      scene.input.considered = considered;
      const auto window = slide(scene.input, "right-sen3", settings, 6).estimates.back();
      const auto batch = smooth(scene.input, "right-sen3", settings).estimates.back();
      EXPECT_LT(apart(window, batch).cwiseAbs().maxCoeff(), 0.02) << name_of(form);
      EXPECT_LT(covariance_difference(window.covariance, batch.covariance), 0.02) << name_of(form);
      EXPECT_LT(
          covariance_difference(window.calibration->covariance, batch.calibration->covariance),
          0.02)
          << name_of(form);
    }
  }
}

// A rotation with rounding errors, which a step of zero would orthonormalise.
TEST(WindowCalibration, ThatIsConsideredIsNotMovedByABit) {
  CalibrationScene scene = calibration_scene({.frames = 10, .landmarks = 40, .seed = 6}, 0.02);
  SE3& stated = scene.input.calibration->imu_T_camera[0];
  stated.R = so3::exp({0.001, -0.002, 0.0015}) * stated.R;
  stated.R(0, 0) += 1e-15;
  scene.input.cameras[0].cam_T_imu = stated.inverse();
  scene.consider_all();
  const auto last = slide(scene.input, "right-sen3", {}, 5).estimates.back();
  const Calibration &held = *last.calibration, &prior = *scene.input.calibration;
  EXPECT_EQ(held.imu_T_camera[0].R, prior.imu_T_camera[0].R);
  EXPECT_EQ(held.imu_T_camera[0].p, prior.imu_T_camera[0].p);
  EXPECT_EQ(held.time_offset, prior.time_offset);
  EXPECT_EQ(held.intrinsics[0].projection, prior.intrinsics[0].projection);
  EXPECT_EQ(held.intrinsics[0].coefficients, prior.intrinsics[0].coefficients);
  EXPECT_EQ(held.intrinsics[0].readout, prior.intrinsics[0].readout);
  EXPECT_TRUE(held.covariance.isApprox(prior.covariance, 1e-6));
}

// The covariance holds, and the states are those of the known calibration.
TEST(WindowCalibration, ThatIsConsideredCountsAndIsNotCorrected) {
  for (const double readout : {0.0, 0.02}) {
    double states = 0;
    int runs = 0;
    for (; runs < 16; ++runs) {
      const auto seed = 700 + static_cast<std::uint64_t>(runs);
      CalibrationScene scene =
          calibration_scene({.frames = 20, .landmarks = 40, .seed = seed}, readout);
      scene.consider_all();
      BatchSettings settings = without_outliers();
      const auto last = slide(scene.input, "right-sen3", settings, 6).estimates.back();
      scene.input.calibration.reset();
      scene.input.considered.clear();
      const auto known = slide(scene.input, "right-sen3", settings, 6).estimates.back();
      EXPECT_LT((last.world_T_imu.p - known.world_T_imu.p).norm(), 1e-6);
      states += squared_error(motion_error(scene.motion_at(last.time), last), last.covariance);
    }
    EXPECT_TRUE(is_chi2(states, 15 * runs)) << readout;
  }
}

TEST(WindowCalibration, MayBeConsideredInPart) {
  double calibrations = 0, states = 0;
  int dof = 0, runs = 0;
  for (; runs < 16; ++runs) {
    const auto seed = 800 + static_cast<std::uint64_t>(runs);
    CalibrationScene scene = calibration_scene({.frames = 20, .landmarks = 40, .seed = seed}, 0.02);
    scene.input.considered = {0, 1, 2, 3, 4, 5, 7, 8};  // the extrinsics; fx, fy
    BatchSettings settings = without_outliers();
    const auto last = slide(scene.input, "right-sen3", settings, 6).estimates.back();
    EXPECT_EQ(last.calibration->intrinsics[0].projection[0], scene.input.cameras[0].fx);
    EXPECT_NE(last.calibration->intrinsics[0].projection[2], scene.input.cameras[0].cx);
    const Eigen::VectorXd e =
        smooth_detail::calibration_difference(scene.true_calibration, *last.calibration);
    calibrations += squared_error(e, last.calibration->covariance);
    dof += static_cast<int>(e.size()) - scene.empty_rows;
    states += squared_error(motion_error(scene.motion_at(last.time), last), last.covariance);
  }
  EXPECT_TRUE(is_chi2(calibrations, dof));
  EXPECT_TRUE(is_chi2(states, 15 * runs));
}

// The covariance factor is not for what considered errors add, of landmarks in the window and of
// those that have left it.
TEST(WindowCalibration, WideErrorsOfTracksDoNotWidenWhatIsConsidered) {
  CalibrationScene scene = calibration_scene({.frames = 12, .landmarks = 40, .seed = 5}, 0.02);
  BatchSettings settings;
  settings.loss = BatchLoss::kNone;
  settings.gate = 0;
  const auto covariances = [&](double factor) {
    settings.covariance_factor = factor;
    const InertialWindowResult result = slide(scene.input, "right-sen3", settings, 6);
    std::vector<Eigen::MatrixXd> all = {result.estimates.back().covariance};
    for (const MapLandmark& landmark : result.landmarks) all.emplace_back(landmark.covariance);
    return all;
  };
  scene.consider_all();
  const auto narrow = covariances(1), wide = covariances(9);
  scene.input.calibration.reset();
  scene.input.considered.clear();
  const auto known = covariances(1);
  ASSERT_EQ(wide.size(), known.size());
  ASSERT_EQ(wide.size(), narrow.size());
  for (std::size_t i = 0; i < wide.size(); ++i) {
    const Eigen::MatrixXd added = narrow[i] - known[i];
    EXPECT_GT(added.trace(), 0.01 * known[i].trace()) << i;
    EXPECT_LT(covariance_difference(wide[i], 9 * known[i] + added), 1e-6) << i;
  }
}

}  // namespace
}  // namespace chasles
