#include <algorithm>

#include <chasles/slam/landmark_updater.hpp>
#include <chasles/slam/step_testing.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using test::some_context;

std::optional<Eigen::Vector2d> predicted_pixel(const State& x, std::size_t landmark,
                                               const Camera& camera) {
  const Eigen::Vector3d p_imu = x.world_T_imu.inverse() * x.p_world(x.landmarks[landmark]);
  const auto seen = project(camera, camera.cam_T_imu * p_imu);
  return seen ? std::optional(seen->pixel) : std::nullopt;
}

// Every landmark by every camera that can, about a pixel from its prediction.
std::vector<PixelObservation> observations_of(const SlamContext& x, test::Random& random) {
  std::vector<PixelObservation> result;
  for (std::size_t c = 0; c < x.cameras.size(); ++c) {
    for (std::size_t i = 0; i < x.state().landmarks.size(); ++i) {
      const auto pixel = predicted_pixel(x.state(), i, x.cameras[c]);
      if (!pixel) continue;
      result.push_back({.landmark = x.state().landmarks[i].id,
                        .camera = static_cast<int>(c),
                        .pixel = *pixel + random.normal_vector(2)});
    }
  }
  return result;
}

// Residuals of these observations as a function of all errors.
VectorXd residuals(const SlamContext& x, const std::vector<PixelObservation>& pixels,
                   const VectorXd& e) {
  const State y = test::moved(kStandardChart, x.state(), e);
  VectorXd r(2 * std::ssize(pixels));
  Eigen::Index at = 0;
  for (const PixelObservation& o : pixels) {
    const auto i = static_cast<std::size_t>(
        std::ranges::find(y.landmarks, o.landmark, &Landmark::id) - y.landmarks.begin());
    r.segment<2>(at) = o.pixel - *predicted_pixel(y, i, x.camera(o.camera));
    at += 2;
  }
  return r;
}

Estimate update(SlamContext& x, LandmarkUpdater& updater,
                const std::vector<PixelObservation>& pixels, bool standstill = false) {
  Estimate e;
  e.zero_velocity = standstill;
  updater.update(x, test::pointers(pixels), false, StudyHooks(x.settings, {}), e);
  return e;
}

TEST(LandmarkUpdater, IsTheKalmanUpdateWithNumericDerivatives) {
  test::Random random(1);
  SlamContext x = some_context(random);
  const auto pixels = observations_of(x, random);
  ASSERT_GT(pixels.size(), 6u);
  const VectorXd zero = VectorXd::Zero(x.state().size());
  const auto r = [&](const VectorXd& e) { return residuals(x, pixels, e); };
  const MatrixXd H = -test::numeric_derivative(r, zero, test::kPixelStep);
  const MatrixXd R = 0.64 * MatrixXd::Identity(H.rows(), H.rows());
  const MatrixXd P = x.filter.covariance(), S = H * P * H.transpose() + R;
  const auto expected = test::updated(x.state(), P, H, R, r(zero));
  const double nis = r(zero).dot(S.inverse() * r(zero));

  LandmarkUpdater updater;
  const Estimate e = update(x, updater, pixels);
  test::expect_updated(x.filter, expected);
  EXPECT_NEAR(e.nis, nis, 1e-6 * nis);
  EXPECT_EQ(e.nis_dof, H.rows());
  EXPECT_EQ(e.used, std::ssize(pixels));
  EXPECT_EQ(e.rejected, 0);
  for (const PixelOutcome& one : updater.outcomes())
    EXPECT_EQ(one.outcome, chasles::Outcome::kUsed);
}

TEST(LandmarkUpdater, AGrossErrorIsRejectedAndChangesNothing) {
  test::Random random(2);
  SlamContext x = some_context(random);
  x.settings.gate = 0.999;
  auto pixels = observations_of(x, random);
  SlamContext without = x;
  LandmarkUpdater updater, other;
  auto fewer = pixels;
  fewer.erase(fewer.begin());
  pixels.front().pixel.x() += 1e4;
  const Estimate e = update(x, updater, pixels), f = update(without, other, fewer);
  EXPECT_EQ(e.used, f.used);
  EXPECT_EQ(e.rejected, f.rejected + 1);
  EXPECT_EQ(updater.outcomes().front().outcome, chasles::Outcome::kRejected);
  EXPECT_LT(test::distance(x.state(), without.state()), 1e-12);
}

TEST(LandmarkUpdater, NewPointsAreFreshAndAStandstillUpdatesNothing) {
  test::Random random(3);
  SlamContext x = some_context(random);
  auto pixels = observations_of(x, random);
  pixels.push_back({.landmark = 7, .camera = 1, .pixel = {100, 100}});
  const State before = x.state();
  LandmarkUpdater updater;
  const Estimate e = update(x, updater, pixels, true);
  EXPECT_EQ(e.used + e.rejected, 0);
  EXPECT_EQ(test::distance(x.state(), before), 0);
  ASSERT_EQ(updater.fresh().size(), 1u);
  EXPECT_EQ(updater.fresh().front()->landmark, 7);
  EXPECT_EQ(updater.outcomes().back().outcome, chasles::Outcome::kWaiting);
}

TEST(LandmarkUpdater, LandmarksLeaveThatAreRejectedOrOutOfView) {
  test::Random random(4);
  SlamContext x = some_context(random);
  x.settings.waiting_frames = 1;
  x.settings.max_rejections = 3;
  for (LandmarkRecord& record : x.records) record = {.seen = x.frame, .cameras = camera_bit(0)};
  x.records[1].rejected = 3;
  x.records[2].seen = x.records[3].seen = x.frame - 1;
  x.records[3].cameras = camera_bit(1);  // which observes nothing now
  LandmarkUpdater updater;
  EXPECT_EQ(updater.find_leaving(x, camera_bit(0)), std::vector<int>{1});
  EXPECT_EQ(x.records[2].missed, 1);
  EXPECT_EQ(updater.find_leaving(x, camera_bit(0)), (std::vector<int>{1, 2}));
  EXPECT_EQ(x.records[3].missed, 0);
}

TEST(LandmarkUpdater, AKnownDepthMakesALandmarkCartesian) {
  test::Random random(5);
  SlamContext x = some_context(random);
  x.settings.settled_depth_sigma = 0;
  LandmarkUpdater updater;
  const auto anchored = [&] {
    return std::ranges::count_if(x.state().landmarks,
                                 [](const Landmark& l) { return l.anchor.has_value(); });
  };
  updater.make_cartesian(x);
  EXPECT_EQ(anchored(), 3);
  x.settings.settled_depth_sigma = 10;
  updater.make_cartesian(x);
  EXPECT_EQ(anchored(), 0);
}

}  // namespace
}  // namespace chasles
