#include <Eigen/LU>

#include <chasles/filter/multi_view_start.hpp>
#include <chasles/filter/pixel_testing.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::camera_of;
using test::kCameras;
using test::kPixelStep;
using test::pixel_of;
using test::some_filter;

// With known and with estimated extrinsics.
class MultiViewStartTest : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Cameras, MultiViewStartTest, testing::Bool(), test::how_known);

// A point observed from all clones by the first camera, and from the last clone by the third one
// too.
struct Tracked {
  Ekf filter;
  std::vector<ClonedView> views;
};

Tracked tracked(test::Random& random, bool calibrating, double pixel_noise, int views_of_each = 1) {
  Tracked result{some_filter(random, calibrating), {}};
  const State& x = result.filter.state();
  const Vector3d p_world = x.world_T_imu * test::point_ahead(random, 8);
  const auto observe = [&](const Clone& clone, int camera) {
    const Vector2d pixel = pixel_of(camera_of(x, camera), clone.world_T_imu, p_world);
    result.views.push_back({.clone = clone.id,
                            .camera = camera,
                            .pixel = pixel + pixel_noise * random.normal_vector(2),
                            .match = camera > 0});
  };
  for (int i = 0; i < views_of_each; ++i) {
    for (const Clone& clone : x.clones) observe(clone, i % 3);
  }
  observe(x.clones[0], 2);
  observe(x.clones.back(), 2);
  return result;
}

// A point 105 degrees off the axis of the fisheye camera, which alone observes it.
Tracked tracked_beside(test::Random& random, bool calibrating, double pixel_noise) {
  constexpr int kFisheye = 2;
  Tracked result{some_filter(random, calibrating), {}};
  const State& x = result.filter.state();
  const Vector3d p_world = x.world_T_imu * Vector3d(-1.6, 5.8, 0.4);
  for (const Clone& clone : x.clones) {
    const Vector2d pixel = pixel_of(camera_of(x, kFisheye), clone.world_T_imu, p_world);
    result.views.push_back({.clone = clone.id,
                            .camera = kFisheye,
                            .pixel = pixel + pixel_noise * random.normal_vector(2)});
  }
  return result;
}

std::optional<MultiViewStart> initialise(const Tracked& t, bool anchored, double sigma = 0.8) {
  return initialise_multi_view(kCameras, {.sigma = sigma}, t.filter.state(), 7, t.views, anchored);
}

// The state with the landmark of a start appended.
State with_landmark(const State& x, const NewLandmark& fresh) {
  State result = x;
  result.landmarks.push_back({.id = fresh.id,
                              .p_world = fresh.p_world,
                              .row = x.size(),
                              .anchor = fresh.anchor,
                              .cam_T_imu = fresh.cam_T_imu,
                              .inverse_depth = fresh.inverse_depth,
                              .camera = fresh.camera,
                              .face = fresh.face});
  return result;
}

// Residuals of all views and their numeric H by all errors, the landmark's last.
struct Batch {
  VectorXd r;
  MatrixXd H;
};

Batch batch_of(const Tracked& t, const NewLandmark& fresh) {
  const State x = with_landmark(t.filter.state(), fresh);
  const auto residuals = [&](const VectorXd& e) -> VectorXd {
    const State y = test::moved(kStandardChart, x, e);
    VectorXd r(2 * static_cast<Eigen::Index>(t.views.size()));
    for (std::size_t i = 0; i < t.views.size(); ++i) {
      const ClonedView& view = t.views[i];
      r.segment<2>(2 * static_cast<Eigen::Index>(i)) =
          view.pixel - pixel_of(camera_of(y, view.camera), y.clone(view.clone).world_T_imu,
                                y.p_world(y.landmarks.back()));
    }
    return r;
  };
  const VectorXd zero = VectorXd::Zero(x.size());
  return {.r = residuals(zero), .H = -test::numeric_derivative(residuals, zero, kPixelStep)};
}

TEST_P(MultiViewStartTest, NullSpaceRowsHaveNothingOfTheLandmarkAndAllThatIsLeftOfTheClones) {
  test::Random random(5);
  for (const int views_of_each : {1, 4}) {
    for (const bool anchored : {false, true}) {
      const Tracked t = tracked(random, GetParam(), 1, views_of_each);
      const auto start = initialise(t, anchored);
      ASSERT_TRUE(start);
      const Batch batch = batch_of(t, start->landmark);
      const Eigen::Index n = t.filter.state().size();
      const auto null_space = test::dense_measurement(
          t.filter.state(), {start->null_space.begin(), start->null_space.end()});
      EXPECT_EQ(start->null_space_rows, batch.r.size() - 3);
      EXPECT_EQ(null_space.r.size(), start->null_space_rows);
      EXPECT_TRUE(test::agree(null_space.R,
                              0.64 * MatrixXd::Identity(null_space.R.rows(), null_space.R.cols()),
                              1e-15));
      // Projects the landmark out of all rows.
      const MatrixXd H_f = batch.H.rightCols<3>();
      const MatrixXd H_x = batch.H.leftCols(n);
      const MatrixXd out = MatrixXd::Identity(H_f.rows(), H_f.rows()) -
                           H_f * (H_f.transpose() * H_f).inverse() * H_f.transpose();
      EXPECT_TRUE(
          test::agree(null_space.H.transpose() * null_space.H, H_x.transpose() * out * H_x, 1e-8));
      EXPECT_TRUE(test::agree(null_space.H.transpose() * null_space.r,
                              H_x.transpose() * out * batch.r, 1e-8));
      EXPECT_NEAR(null_space.r.squaredNorm(), batch.r.dot(out * batch.r), 1e-8);
    }
  }
}

// Each observation counts exactly once: after addition and update, the filter equals batch least
// squares of all rows with a flat prior of the landmark.
TEST_P(MultiViewStartTest, LandmarkAndNullSpaceTogetherAreTheBatchSolution) {
  test::Random random(6);
  constexpr double kSigma = 0.8;
  for (const bool anchored : {false, true}) {
    Tracked t = tracked(random, GetParam(), 0.5, 3);
    const auto start = initialise(t, anchored, kSigma);
    ASSERT_TRUE(start);
    const State before = with_landmark(t.filter.state(), start->landmark);
    const Batch batch = batch_of(t, start->landmark);
    const Eigen::Index n = t.filter.state().size();
    MatrixXd information = batch.H.transpose() * batch.H / (kSigma * kSigma);
    information.topLeftCorner(n, n) += t.filter.covariance().inverse();
    const MatrixXd P = information.inverse();
    const VectorXd delta = P * batch.H.transpose() * batch.r / (kSigma * kSigma);

    t.filter.add({&start->landmark, 1});
    ASSERT_FALSE(t.filter.update(start->null_space).failed);
    const State expected = test::moved(kStandardChart, before, delta);
    EXPECT_LT(test::distance(t.filter.state(), expected), 1e-8);
    EXPECT_GT(test::distance(before, expected), 1e-3);
    EXPECT_LT(test::covariance_difference(t.filter.covariance(), P), 1e-8);
    EXPECT_EQ(t.filter.state().landmarks.back().observations, static_cast<int>(t.views.size()));
  }
}

// The same with a track that drifts: batch least squares weighted by the covariance of its views.
// They meet in a point, so that the weights do not move it.
TEST_P(MultiViewStartTest, OfADriftingTrackItIsTheWeightedBatchSolution) {
  test::Random random(10);
  constexpr TrackNoise kNoise{.sigma = 0.4, .drift = 1.5, .match = 0.7};
  for (const bool anchored : {false, true}) {
    Tracked t = tracked(random, GetParam(), 0);
    const State x = t.filter.state();
    const auto time = [&](std::size_t view) { return x.clone(t.views[view].clone).time; };
    const auto start =
        initialise_multi_view(kCameras, kNoise, t.filter.state(), 7, t.views, anchored);
    ASSERT_TRUE(start);
    EXPECT_EQ(start->landmark.matches, 2);
    const Batch batch = batch_of(t, start->landmark);
    MatrixXd R = MatrixXd::Zero(batch.r.size(), batch.r.size());
    for (std::size_t i = 0; i < t.views.size(); ++i) {
      for (std::size_t j = 0; j < t.views.size(); ++j) {
        const double shared = to_seconds(time(t.views.size() - 1) - std::max(time(i), time(j)));
        const bool matches = t.views[i].camera > 0 && t.views[j].camera > 0;
        const double variance =
            (i == j ? 0.16 : 0) + 1.5 * 1.5 * shared + (matches ? 0.7 * 0.7 : 0);
        R.block<2, 2>(2 * static_cast<Eigen::Index>(i), 2 * static_cast<Eigen::Index>(j)) =
            variance * Eigen::Matrix2d::Identity();
      }
    }
    const Eigen::Index n = x.size();
    MatrixXd information = batch.H.transpose() * R.inverse() * batch.H;
    information.topLeftCorner(n, n) += t.filter.covariance().inverse();
    const MatrixXd P = information.inverse();
    Ekf white = t.filter;
    t.filter.add({&start->landmark, 1});
    ASSERT_FALSE(t.filter.update(start->null_space).failed);
    EXPECT_LT(test::covariance_difference(t.filter.covariance(), P), 1e-8);
    const auto of_white = initialise(t, anchored, kNoise.sigma);
    white.add({&of_white->landmark, 1});
    white.update(of_white->null_space);
    EXPECT_GT(test::covariance_difference(white.covariance(), P), 0.01);
  }
}

// The least-squares point of the views, by Gauss-Newton from a nearby point.
Vector3d least_squares_point(const State& x, const std::vector<ClonedView>& views, Vector3d point) {
  for (int i = 0; i < 8; ++i) {
    Matrix3d N = Matrix3d::Zero();
    Vector3d b = Vector3d::Zero();
    for (const ClonedView& view : views) {
      const Camera camera = camera_of(x, view.camera);
      const SE3 cam_T_world = camera.cam_T_imu * x.clone(view.clone).world_T_imu.inverse();
      const auto seen = project(camera, cam_T_world * point);
      const MatrixXd J = seen->d_point * cam_T_world.R;
      N += J.transpose() * J;
      b += J.transpose() * (view.pixel - seen->pixel);
    }
    point += N.inverse() * b;
  }
  return point;
}

// If all views meet in the point, the Gauss-Newton derivatives are exact.
TEST_P(MultiViewStartTest, DerivativesAreThoseOfTheLeastSquaresPoint) {
  test::Random random(7);
  const Tracked t = tracked(random, GetParam(), 0);
  const State& x = t.filter.state();
  const auto start = initialise(t, false, 0.8);
  ASSERT_TRUE(start);
  // The point and its distance from the last view's IMU.
  const auto point_of = [&](const VectorXd& e, const VectorXd& d_pixels) -> VectorXd {
    std::vector<ClonedView> views = t.views;
    for (std::size_t i = 0; i < views.size(); ++i) {
      views[i].pixel += d_pixels.segment<2>(2 * static_cast<Eigen::Index>(i));
    }
    const State y = test::moved(kStandardChart, x, e);
    const Vector3d p = least_squares_point(y, views, start->landmark.p_world);
    const Vector3d last = y.clone(views.back().clone).world_T_imu.p;
    return Eigen::Vector4d(p.x(), p.y(), p.z(), (p - last).norm());
  };
  const VectorXd no_error = VectorXd::Zero(x.size());
  const VectorXd no_pixels = VectorXd::Zero(2 * static_cast<Eigen::Index>(t.views.size()));
  const MatrixXd by_error = test::numeric_derivative(
      [&](const VectorXd& e) { return point_of(e, no_pixels); }, no_error, kPixelStep);
  const MatrixXd by_pixel = test::numeric_derivative(
      [&](const VectorXd& d) { return point_of(no_error, d); }, no_pixels, 1e-2);

  const VectorXd point = point_of(no_error, no_pixels);
  EXPECT_TRUE(test::agree(start->landmark.p_world, point.head<3>(), 1e-10));
  EXPECT_NEAR(start->distance, point[3], 1e-10);
  MatrixXd J = MatrixXd::Zero(4, x.size());
  for (const auto& clone : start->landmark.clones) J.block<3, 6>(0, clone.row) = clone.d;
  for (const auto& clone : start->d_distance) J.block<1, 6>(3, clone.row) = clone.d;
  EXPECT_TRUE(test::agree(J, by_error, 1e-7));
  const MatrixXd noise = 0.64 * by_pixel * by_pixel.transpose();
  EXPECT_TRUE(test::agree(start->landmark.noise, noise.topLeftCorner<3, 3>(), 1e-7, 0));
  EXPECT_NEAR(start->distance_noise, noise(3, 3), 1e-7 * noise(3, 3));
  const double variance = (by_error * t.filter.covariance() * by_error.transpose() + noise)(3, 3);
  EXPECT_GT(variance, 1.1 * noise(3, 3));  // the clones matter
  EXPECT_NEAR(relative_depth_sigma(*start, t.filter), std::sqrt(variance) / start->distance, 1e-7);
}

TEST_P(MultiViewStartTest, AnchoredIsTheSamePointOnTheLastViewsClone) {
  test::Random random(8);
  for (const Tracked& t :
       {tracked(random, GetParam(), 0.5), tracked_beside(random, GetParam(), 0.1)}) {
    const auto cartesian = initialise(t, false);
    const auto anchored = initialise(t, true);
    ASSERT_TRUE(cartesian && anchored);
    ASSERT_TRUE(anchored->landmark.anchor);
    EXPECT_EQ(*anchored->landmark.anchor, t.views.back().clone);
    const State x = with_landmark(t.filter.state(), anchored->landmark);
    EXPECT_LT((x.p_world(x.landmarks.back()) - cartesian->landmark.p_world).norm(), 1e-11);

    // The joint covariance of clones and position does not depend on the form of the new landmark.
    Ekf one = t.filter;
    Ekf other = t.filter;
    one.add({&cartesian->landmark, 1});
    other.add({&anchored->landmark, 1});
    other.make_cartesian(static_cast<int>(other.state().landmarks.size()) - 1);
    EXPECT_LT(test::covariance_difference(other.covariance(), one.covariance()), 1e-9);
  }
  // In the axes of another face.
  const auto beside = initialise(tracked_beside(random, GetParam(), 0.1), true);
  EXPECT_NE(beside->landmark.face, AnchorFace::kFront);
}

TEST_P(MultiViewStartTest, ViewsThatDoNotMeetBeginNothing) {
  test::Random random(9);
  Tracked t = tracked(random, GetParam(), 0);
  t.views.resize(1);
  EXPECT_FALSE(initialise(t, false));
}

}  // namespace
}  // namespace chasles
