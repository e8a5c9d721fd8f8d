#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/filter/testing.hpp>
#include <chasles/smooth/batch/calibration_scene_testing.hpp>
#include <chasles/smooth/batch/exact_settings_testing.hpp>
#include <chasles/smooth/terms/calibration_blocks_detail.hpp>

// The IMU's parameters as a state of batch estimation.
namespace chasles {
namespace {

using namespace test;

// Alone, or with all of the cameras.
CalibrationScene wrong_scene(bool cameras, std::uint64_t seed) {
  const SmallFlight flight{.frames = 12, .seed = seed};
  if (!cameras) return imu_scene(flight);
  CalibrationScene scene = calibration_scene(flight, 0.02);
  measure_wrongly(scene, seed);
  return scene;
}

struct Squares {
  double calibrations = 0, states = 0;
  int dof = 0, runs = 0;

  void add(const CalibrationScene& scene, const Estimate& last) {
    const Eigen::VectorXd e =
        smooth_detail::calibration_difference(scene.true_calibration, *last.calibration);
    calibrations += squared_error(e, last.calibration->covariance);
    dof += static_cast<int>(e.size()) - scene.empty_rows;
    states += squared_error(motion_error(scene.motion_at(last.time), last), last.covariance);
    ++runs;
  }
};

TEST(BatchImu, IsWrongByAsMuchAsItSays) {
  for (const bool cameras : {false, true}) {
    Squares squares;
    for (std::uint64_t seed = 300; seed < 325; ++seed) {
      const CalibrationScene scene = wrong_scene(cameras, seed);
      squares.add(scene, smooth(scene.input, "right-sen3", without_outliers()).estimates.back());
    }
    EXPECT_TRUE(is_chi2(squares.calibrations, squares.dof)) << cameras;
    EXPECT_TRUE(is_chi2(squares.states, 15 * squares.runs)) << cameras;
  }
}

// And it matters: as known, the same IMUs contradict.
TEST(BatchImu, ThatIsTakenAsStatedIsWrongByMore) {
  double states = 0;
  for (std::uint64_t seed = 300; seed < 310; ++seed) {
    CalibrationScene scene = wrong_scene(false, seed);
    scene.input.calibration.reset();
    const Estimate last = smooth(scene.input, "right-sen3", without_outliers()).estimates.back();
    states += squared_error(motion_error(scene.motion_at(last.time), last), last.covariance);
  }
  EXPECT_GT(states, 2 * 15 * 10);
}

TEST(BatchImu, ThatIsConsideredIsNotCorrected) {
  double states = 0;
  int runs = 0;
  for (std::uint64_t seed = 400; seed < 425; ++seed, ++runs) {
    CalibrationScene scene = wrong_scene(false, seed);
    scene.consider_all();
    const Estimate last = smooth(scene.input, "right-sen3", without_outliers()).estimates.back();
    EXPECT_TRUE(last.calibration->imu->parameters().isZero(0));
    EXPECT_TRUE(last.calibration->covariance.isApprox(scene.input.calibration->covariance, 1e-6));
    states += squared_error(motion_error(scene.motion_at(last.time), last), last.covariance);
  }
  EXPECT_TRUE(is_chi2(states, 15 * runs));
}

// Exact data and a weak prior: what the motion shows is found.
TEST(BatchImu, FindsWhatIsWrong) {
  for (const LandmarkForm form : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    CalibrationScene scene =
        imu_scene({.frames = 60, .cameras = 2, .noise = 0, .landmarks = 80, .seed = 7});
    scene.input.calibration->covariance *= 1e4;
    scene.input.initial = scene.truth;
    const InertialBatchResult result = smooth(scene.input, "right-sen3", exact_settings(form));
    const Calibration& found = *result.estimates.back().calibration;
    const Eigen::VectorXd e = smooth_detail::calibration_difference(scene.true_calibration, found);
    const Eigen::VectorXd sigma = found.covariance.diagonal().cwiseSqrt();
    EXPECT_LT(e.cwiseQuotient(sigma).cwiseAbs().maxCoeff(), 0.3);
    EXPECT_LT(sigma.minCoeff(), 0.01);
    EXPECT_TRUE(result.report.converged);
  }
}

// Of a correlated prior, as an earlier part of a recording leaves it: the start of the later part
// is that which the filter found with its own parameters.
TEST(BatchImu, TheStartMayHaveBeenFoundWithOtherParameters) {
  CalibrationScene scene = wrong_scene(false, 31);
  InertialStart& start = scene.input.start;
  start.by_imu.topRows<9>().setZero();  // the biases' errors add up exactly
  const auto velocity = [&] {
    return *smooth(scene.input, "right-sen3", without_outliers()).estimates.back().v_world;
  };
  const Eigen::Vector3d stated = velocity();
  Calibration& own = start.calibration.emplace(*scene.input.calibration);
  Random random(1);
  own.imu->set(0.02 * random.normal_vector(own.imu->size()));
  const Eigen::VectorXd e = start.by_imu * own.imu->parameters();
  start.accelerometer_bias += e.segment<3>(9);
  start.gyroscope_bias += e.tail<3>();
  const Eigen::Vector3d known = velocity();
  start.calibration.reset();
  EXPECT_LT((known - stated).norm(), 1e-5);
  EXPECT_GT((velocity() - stated).norm(), 1e-3);
}

TEST(BatchImu, OfAnotherSizeThanTheStartsIsAnError) {
  CalibrationScene scene = wrong_scene(false, 5);
  scene.input.start.by_imu = Eigen::MatrixXd::Zero(15, 6);
  try {
    smooth(scene.input, "right-sen3", {});
    FAIL() << "expected an error";
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("depends on 6 of them, expected all 24"),
              std::string::npos);
  }
}

}  // namespace
}  // namespace chasles
