#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <chasles/camera/camera.hpp>
#include <chasles/smooth/batch/batch_terms.hpp>
#include <chasles/smooth/batch/calibration_scene_testing.hpp>

namespace chasles {
namespace {

using test::small_scene;
using test::SmallScene;
using Vector15 = Eigen::Matrix<double, 15, 1>;

double squared(const Vector15& e, const Matrix15d& covariance) {
  // Scaled, because the start's floors are many powers of ten below its sigmas.
  const Vector15 s = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const Matrix15d unit = s.asDiagonal() * covariance * s.asDiagonal();
  const Vector15 scaled = s.cwiseProduct(e);
  return scaled.dot(unit.ldlt().solve(scaled));
}

Vector15 world_difference(const InertialState& a, const InertialState& b) {
  Vector15 d;
  d << so3::log(a.world_T_imu.R * b.world_T_imu.R.transpose()), a.world_T_imu.p - b.world_T_imu.p,
      a.v_world - b.v_world, a.accelerometer_bias - b.accelerometer_bias,
      a.gyroscope_bias - b.gyroscope_bias;
  return d;
}

// With the strapdown steps from the keyframe itself, so that mean and covariance are in world axes.
double link_square(const InertialState& now, const InertialState& next,
                   const std::vector<ImuInterval>& between, const BatchTerms& terms) {
  InertialState state = now;
  Matrix15d P = Matrix15d::Zero();
  for (const ImuInterval& interval : between) {
    const StrapdownStep step = strapdown(state, interval, terms.gravity, terms.noise);
    P = (step.F * P * step.F.transpose() + step.Q).eval();
    state = step.state;
  }
  return squared(world_difference(next, state), P);
}

double inverse_depth_square(const BatchTerms::Point& point, const BatchTerms& terms) {
  if (!terms.inverse_depth_sigma) return 0;
  const BatchTerms::View& anchor = point.views.front();
  const Camera& camera = terms.cameras[static_cast<std::size_t>(anchor.camera)];
  const SE3& nav_T_imu =
      terms.keyframes[static_cast<std::size_t>(anchor.keyframe)].state.world_T_imu;
  const double z = (camera.cam_T_imu * (nav_T_imu.inverse() * point.p_nav)).z();
  return std::pow(1 / z / *terms.inverse_depth_sigma, 2);
}

// Half of the squares, from nothing but the terms; without a loss.
double cost_of(const BatchTerms& terms) {
  double squares =
      squared(world_difference(terms.keyframes.front().state, terms.start), terms.start_covariance);
  for (std::size_t k = 0; k + 1 < terms.keyframes.size(); ++k) {
    squares += link_square(terms.keyframes[k].state, terms.keyframes[k + 1].state, terms.between[k],
                           terms);
  }
  for (const BatchTerms::Point& point : terms.points) {
    squares += inverse_depth_square(point, terms);
    for (const BatchTerms::View& view : point.views) {
      const Camera& camera = terms.cameras[static_cast<std::size_t>(view.camera)];
      const SE3& nav_T_imu =
          terms.keyframes[static_cast<std::size_t>(view.keyframe)].state.world_T_imu;
      const auto seen = project(camera, camera.cam_T_imu * (nav_T_imu.inverse() * point.p_nav));
      if (!seen) return std::nan("");
      squares += ((seen->pixel - view.pixel) / view.sigma).squaredNorm();
    }
  }
  return squares / 2;
}

BatchSettings plain(LandmarkForm landmarks) {
  BatchSettings settings;
  settings.landmarks = landmarks;
  settings.loss = BatchLoss::kNone;
  settings.gate = 0;
  settings.min_parallax = 0;
  return settings;
}

TEST(BatchTerms, AreTheWholeCost) {
  SmallScene scene = small_scene({.frames = 12, .cameras = 2});
  scene.input.match_sigma = 0.3;
  for (const LandmarkForm form : {LandmarkForm::kCartesian, LandmarkForm::kInverseDepth}) {
    const InertialBatchResult result = smooth(scene.input, "standard", plain(form));
    ASSERT_EQ(result.terms.size(), 1U);
    const BatchTerms& terms = *result.terms.front();
    EXPECT_EQ(terms.cost, result.report.final_cost);
    EXPECT_EQ(terms.inverse_depth_cost > 0, form == LandmarkForm::kInverseDepth);
    EXPECT_EQ(terms.inverse_depth_sigma.has_value(), form == LandmarkForm::kInverseDepth);
    // The covariance of the samples is that at the biases from which the search began.
    EXPECT_NEAR(cost_of(terms) / terms.cost, 1, 1e-4);
    EXPECT_EQ(terms.beyond_infinity, 0);
  }
}

// The samples are those that the parameters at the minimum correct, and the start's mean is that
// which they imply.
TEST(BatchTerms, OfAnEstimatedImuAreTheWholeCost) {
  const test::CalibrationScene scene = test::imu_scene({.frames = 12, .cameras = 2});
  const InertialBatchResult result =
      smooth(scene.input, "standard", plain(LandmarkForm::kCartesian));
  const BatchTerms& terms = *result.terms.front();
  EXPECT_GT(terms.calibration_cost, 0);
  EXPECT_NEAR((cost_of(terms) + terms.calibration_cost) / terms.cost, 1, 1e-3);
}

TEST(BatchTerms, HoldTheEstimatesAndTheMap) {
  const SmallScene scene = small_scene({.frames = 10});
  const InertialBatchResult result =
      smooth(scene.input, "standard", plain(LandmarkForm::kInverseDepth));
  const BatchTerms& terms = *result.terms.front();
  ASSERT_EQ(terms.keyframes.size(), result.estimates.size());
  for (std::size_t k = 0; k < terms.keyframes.size(); ++k) {
    EXPECT_EQ(terms.keyframes[k].time, result.estimates[k].time);
    EXPECT_EQ(terms.keyframes[k].state.world_T_imu.p, result.estimates[k].world_T_imu.p);
    EXPECT_EQ(terms.keyframes[k].state.biases(), result.estimates[k].additive);
  }
  ASSERT_EQ(terms.points.size(), result.landmarks.size());
  for (std::size_t i = 0; i < terms.points.size(); ++i) {
    EXPECT_EQ(terms.points[i].id, result.landmarks[i].id);
    EXPECT_LT((terms.points[i].p_nav - result.landmarks[i].p_world).norm(), 1e-12);
  }
}

TEST(BatchTerms, HaveTheViewsThatTheGateLeft) {
  SmallScene scene = small_scene({.frames = 10, .cameras = 2});
  scene.input.frames[5].pixels[3].pixel.x() += 60;
  BatchSettings settings;
  settings.min_parallax = 0;
  const InertialBatchResult result = smooth(scene.input, "standard", settings);
  const BatchTerms& terms = *result.terms.front();
  EXPECT_EQ(terms.loss, BatchLoss::kHuber);
  EXPECT_EQ(terms.loss_width, result.report.loss_width);
  std::size_t views = 0;
  for (const BatchTerms::Point& point : terms.points) views += point.views.size();
  EXPECT_EQ(views, static_cast<std::size_t>(result.report.observations));
  EXPECT_GE(result.report.gated, 1);
  const PixelObservation& wrong = scene.input.frames[5].pixels[3];
  for (const BatchTerms::Point& point : terms.points) {
    EXPECT_TRUE(std::ranges::none_of(
        point.views, [&](const BatchTerms::View& v) { return v.pixel == wrong.pixel; }));
  }
}

}  // namespace
}  // namespace chasles
