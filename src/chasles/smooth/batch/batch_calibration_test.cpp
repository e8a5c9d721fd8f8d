#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/filter/testing.hpp>
#include <chasles/smooth/batch/batch_terms.hpp>
#include <chasles/smooth/batch/calibration_scene_testing.hpp>
#include <chasles/smooth/batch/exact_settings_testing.hpp>
#include <chasles/smooth/terms/calibration_blocks_detail.hpp>

// The calibration as a state of batch estimation.
namespace chasles {
namespace {

using namespace test;

// All of it, of one camera or two, with a global shutter or a rolling one.
TEST(BatchCalibration, IsWrongByAsMuchAsItSays) {
  for (const double readout : {0.0, 0.02}) {
    double calibrations = 0, states = 0;
    int dof = 0, runs = 0;
    for (; runs < 25; ++runs) {
      const auto seed = 300 + static_cast<std::uint64_t>(runs);
      const CalibrationScene scene =
          calibration_scene({.frames = 10, .cameras = 1 + runs % 2, .seed = seed}, readout);
      const InertialBatchResult result = smooth(scene.input, "right-sen3", without_outliers());
      const Estimate& last = result.estimates.back();
      ASSERT_TRUE(last.calibration);
      const Eigen::VectorXd e =
          smooth_detail::calibration_difference(scene.true_calibration, *last.calibration);
      calibrations += squared_error(e, last.calibration->covariance);
      dof += static_cast<int>(e.size()) - scene.empty_rows;
      const Eigen::VectorXd x = motion_error(scene.motion_at(last.time), last);
      states += squared_error(x, last.covariance);
    }
    EXPECT_TRUE(is_chi2(calibrations, dof)) << readout;
    EXPECT_TRUE(is_chi2(states, 15 * runs)) << readout;
  }
}

// The optimum is that of the known calibration, and the covariance has its errors besides.
TEST(BatchCalibration, ThatIsConsideredIsNotCorrected) {
  for (const double readout : {0.0, 0.02}) {
    double states = 0;
    int runs = 0;
    for (; runs < 25; ++runs) {
      const auto seed = 400 + static_cast<std::uint64_t>(runs);
      CalibrationScene scene = calibration_scene({.frames = 10, .seed = seed}, readout);
      scene.consider_all();
      const InertialBatchResult result = smooth(scene.input, "right-sen3", without_outliers());
      InertialBatchInput known = scene.input;
      known.calibration.reset();
      known.considered.clear();
      const InertialBatchResult fixed = smooth(known, "right-sen3", without_outliers());
      ASSERT_EQ(result.estimates.size(), fixed.estimates.size());
      const Estimate &last = result.estimates.back(), &alone = fixed.estimates.back();
      EXPECT_LT((last.world_T_imu.p - alone.world_T_imu.p).norm(), 1e-5);
      EXPECT_GT(last.covariance(3, 3), alone.covariance(3, 3));
      EXPECT_TRUE(last.calibration->covariance.isApprox(scene.input.calibration->covariance, 1e-6));
      const Eigen::VectorXd x = motion_error(scene.motion_at(last.time), last);
      states += squared_error(x, last.covariance);
    }
    EXPECT_TRUE(is_chi2(states, 15 * runs)) << readout;
  }
}

// Exact data and a weak prior: what is wrong is found.
TEST(BatchCalibration, FindsWhatIsWrong) {
  for (const LandmarkForm form : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    CalibrationScene scene =
        calibration_scene({.frames = 40, .noise = 0, .landmarks = 80, .seed = 7}, 0.02);
    scene.input.calibration->covariance *= 1e4;
    BatchSettings settings = exact_settings(form);
    settings.gate = 0;
    const InertialBatchResult result = smooth(scene.input, "right-sen3", settings);
    const Calibration& found = *result.estimates.back().calibration;
    const Eigen::VectorXd e = smooth_detail::calibration_difference(scene.true_calibration, found);
    const Eigen::VectorXd sigma = found.covariance.diagonal().cwiseSqrt();
    EXPECT_LT(e.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 0.1);
    EXPECT_LT(std::abs(*found.time_offset - *scene.true_calibration.time_offset), 1e-4);
    EXPECT_LT(
        (found.intrinsics[0].projection - scene.true_calibration.intrinsics[0].projection).norm(),
        0.5);
    EXPECT_TRUE(result.report.converged);
    EXPECT_EQ(result.terms.front()->cameras.front().fx, found.intrinsics[0].projection[0]);
    EXPECT_GT(result.terms.front()->calibration_cost, 0);
  }
}

// Where some parts are considered and others estimated, rows of the same block may be both.
TEST(BatchCalibration, MayBeConsideredInPart) {
  double calibrations = 0, states = 0;
  int dof = 0, runs = 0;
  for (; runs < 25; ++runs) {
    const auto seed = 500 + static_cast<std::uint64_t>(runs);
    CalibrationScene scene = calibration_scene({.frames = 10, .seed = seed}, 0.02);
    scene.input.considered = {0, 1, 2, 3, 4, 5, 7, 8};  // the extrinsics; fx, fy
    const InertialBatchResult result = smooth(scene.input, "right-sen3", without_outliers());
    const Estimate& last = result.estimates.back();
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

// Of a correlated prior, as an earlier part of a recording leaves it.
TEST(BatchCalibration, ThePriorMayBeThatOfAnEarlierPart) {
  const CalibrationScene first = calibration_scene({.frames = 10, .seed = 21}, 0.02);
  const Calibration known =
      *smooth(first.input, "right-sen3", without_outliers()).estimates.back().calibration;
  CalibrationScene second = calibration_scene({.frames = 10, .seed = 21}, 0.02);
  second.input.calibration = known;
  const Calibration both =
      *smooth(second.input, "right-sen3", without_outliers()).estimates.back().calibration;
  const Eigen::VectorXd before = known.covariance.diagonal(), after = both.covariance.diagonal();
  EXPECT_LT(after.cwiseQuotient(before).maxCoeff(), 1 + 1e-6);
  EXPECT_LT(after.cwiseQuotient(before).minCoeff(), 0.7);
}

TEST(BatchCalibration, WideErrorsOfTracksDoNotWidenThePrior) {
  const CalibrationScene scene = calibration_scene({.frames = 10, .seed = 5}, 0.02);
  BatchSettings settings = without_outliers();
  const Calibration narrow =
      *smooth(scene.input, "right-sen3", settings).estimates.back().calibration;
  settings.covariance_factor = 100;
  const Calibration wide =
      *smooth(scene.input, "right-sen3", settings).estimates.back().calibration;
  const Eigen::VectorXd prior = scene.input.calibration->covariance.diagonal();
  const Eigen::VectorXd least = narrow.covariance.diagonal(), most = wide.covariance.diagonal();
  EXPECT_GT(most.cwiseQuotient(least).maxCoeff(), 5);
  EXPECT_LT(most.cwiseQuotient(prior).maxCoeff(), 1 + 1e-6);
}

// Nor what considered errors add.
TEST(BatchCalibration, WideErrorsOfTracksDoNotWidenWhatIsConsidered) {
  CalibrationScene scene = calibration_scene({.frames = 10, .seed = 5}, 0.02);
  BatchSettings settings = without_outliers();
  const auto last = [&] { return smooth(scene.input, "right-sen3", settings).estimates.back(); };
  scene.consider_all();
  const Estimate narrow = last();
  settings.covariance_factor = 9;
  const Estimate wide = last();
  scene.input.calibration.reset();
  scene.input.considered.clear();
  const Estimate known = last();
  EXPECT_TRUE(wide.calibration->covariance.isApprox(narrow.calibration->covariance, 1e-9));
  const Eigen::MatrixXd added = narrow.covariance - known.covariance / 9;
  EXPECT_LT(covariance_difference(wide.covariance, known.covariance + added), 1e-3);
}

TEST(BatchCalibration, ThatDoesNotFitIsAnError) {
  const CalibrationScene scene = calibration_scene({.frames = 6, .seed = 5}, 0);
  const auto message = [&](const auto& change) -> std::string {
    InertialBatchInput input = scene.input;
    change(input);
    try {
      smooth(input, "right-sen3", {});
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message([](auto& in) {
              in.calibration->imu_T_camera.emplace_back();
            }).find("2 extrinsics, 1 intrinsics"),
            std::string::npos);
  EXPECT_NE(message([](auto& in) { in.calibration->covariance.resize(3, 3); }).find("of 3 rows"),
            std::string::npos);
  EXPECT_NE(message([](auto& in) { in.calibration->imu.emplace(); }).find("and 43 rows"),
            std::string::npos);
  EXPECT_NE(message([](auto& in) { in.considered = {99}; }).find("row 99"), std::string::npos);
  EXPECT_NE(message([](auto& in) {
              in.calibration->covariance(0, 0) = -1;
            }).find("not positive semidefinite"),
            std::string::npos);
}

}  // namespace
}  // namespace chasles
