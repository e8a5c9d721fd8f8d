#include <Eigen/LU>

#include <chasles/filter/pixel_testing.hpp>

namespace chasles {
namespace {

using Eigen::Matrix2d;
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

// Pixels off the axis; in the fisheye camera also 84 to 124 degrees off.
std::vector<Vector2d> pixels_of(int index) {
  const Camera& camera = kCameras[static_cast<std::size_t>(index)];
  const Vector2d centre(camera.cx, camera.cy);
  std::vector<Vector2d> pixels = {centre + Vector2d(90, -60)};
  if (index < 2) return pixels;
  for (const Vector2d& off : {Vector2d(280, 20), Vector2d(300, -110), Vector2d(-310, 20),
                              Vector2d(10, 330), Vector2d(-30, -400)}) {
    pixels.push_back(centre + off);
  }
  return pixels;
}

Landmark landmark_of(const NewLandmark& made, int row) {
  return {.id = made.id,
          .row = row,
          .anchor = made.anchor,
          .cam_T_imu = made.cam_T_imu,
          .inverse_depth = made.inverse_depth,
          .camera = made.camera,
          .face = made.face};
}

// With known and with estimated extrinsics.
class PixelMeasurement : public testing::TestWithParam<bool> {};
class NewPixelLandmark : public testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Cameras, PixelMeasurement, testing::Bool(), test::how_known);
INSTANTIATE_TEST_SUITE_P(Cameras, NewPixelLandmark, testing::Bool(), test::how_known);

TEST_P(PixelMeasurement, HasTheDerivativeOfItsResidual) {
  test::Random random(1);
  const State x = some_filter(random, GetParam()).state();
  const VectorXd zero = VectorXd::Zero(x.size());
  int anchored = 0;
  for (int index = 0; index < 3; ++index) {
    const Camera& camera = kCameras[static_cast<std::size_t>(index)];
    const auto measure = [&](const State& y, int i, const Vector2d& pixel) {
      return measure_pixel(camera, 0.7, y, i, pixel, Linearisation::kCurrent, index);
    };
    for (int i = 0; i < static_cast<int>(x.landmarks.size()); ++i) {
      const Vector2d pixel(123, 234);
      const auto z = measure(x, i, pixel);
      ASSERT_TRUE(z);
      const auto residual = [&](const VectorXd& e) -> VectorXd {
        const State y = test::moved(kStandardChart, x, e);
        return measure(y, i, pixel)->residual;
      };
      const MatrixXd H = test::dense_measurement(x, {*z}).H;
      EXPECT_TRUE(test::agree(-H, test::numeric_derivative(residual, zero, kPixelStep), 1e-9));
      const auto& landmark = x.landmarks[static_cast<std::size_t>(i)];
      const Vector2d expected = pixel_of(camera_of(x, index), x.world_T_imu, x.p_world(landmark));
      EXPECT_TRUE(test::agree(z->residual, pixel - expected, 1e-12));
      EXPECT_TRUE(test::agree(z->noise, 0.49 * MatrixXd::Identity(2, 2), 1e-15));
      anchored += landmark.anchor ? 1 : 0;
    }
  }
  EXPECT_EQ(anchored, 9);
}

// Also where both the anchor's camera and this one have the point beside or behind them.
TEST_P(PixelMeasurement, BesideTheCameraHasTheDerivativeOfItsResidual) {
  test::Random random(12);
  constexpr int kFisheye = 2;
  const Camera& camera = kCameras[kFisheye];
  int beside = 0;
  for (const Vector2d& pixel : pixels_of(kFisheye)) {
    for (const double inverse_depth : {0.3, 0.0, -0.02}) {
      State x = some_filter(random, GetParam()).state();
      x.world_T_imu = x.clones.back().world_T_imu;
      x.landmarks = {landmark_of(
          *initialise_anchored(camera, 1, x, 6, pixel, inverse_depth, 0.1, kFisheye), x.size())};
      beside += x.landmarks.front().face != AnchorFace::kFront;
      x.world_T_imu.p += 0.3 * random.axis();
      x.world_T_imu.R = x.world_T_imu.R * so3::exp(0.1 * random.axis());
      const auto measure = [&](const VectorXd& e) {
        return measure_pixel(camera, 1, test::moved(kStandardChart, x, e), 0, pixel,
                             Linearisation::kCurrent, kFisheye);
      };
      const VectorXd zero = VectorXd::Zero(x.size());
      const auto z = measure(zero);
      ASSERT_TRUE(z) << pixel.transpose();
      const auto residual = [&](const VectorXd& e) -> VectorXd { return measure(e)->residual; };
      const MatrixXd H = test::dense_measurement(x, {*z}).H;
      EXPECT_TRUE(test::agree(-H, test::numeric_derivative(residual, zero, kPixelStep), 1e-8));
    }
  }
  EXPECT_EQ(beside, 15);
}

// Noise may move an assumed depth to infinity or beyond: the direction still has a projection.
TEST_P(PixelMeasurement, NeedsNoDepth) {
  test::Random random(8);
  for (const double inverse_depth : {1e-9, 0.0, -0.02}) {
    State x = some_filter(random, GetParam()).state();
    const VectorXd zero = VectorXd::Zero(x.size());
    int seen = 0;
    for (int i = 0; i < static_cast<int>(x.landmarks.size()); ++i) {
      Landmark& landmark = x.landmarks[static_cast<std::size_t>(i)];
      if (!landmark.anchor) continue;
      landmark.inverse_depth.z() = inverse_depth;
      for (int index = 0; index < 3; ++index) {
        const auto measure = [&](const VectorXd& e) {
          return measure_pixel(kCameras[static_cast<std::size_t>(index)], 1,
                               test::moved(kStandardChart, x, e), i, {123, 234},
                               Linearisation::kCurrent, index);
        };
        const auto z = measure(zero);
        if (!z) continue;  // outside the camera's view
        ++seen;
        const auto residual = [&](const VectorXd& e) -> VectorXd { return measure(e)->residual; };
        const MatrixXd H = test::dense_measurement(x, {*z}).H;
        EXPECT_TRUE(test::agree(-H, test::numeric_derivative(residual, zero, kPixelStep), 1e-9));
      }
    }
    EXPECT_GE(seen, 6) << inverse_depth;
  }
}

// Difference of a pixel from its linear prediction, for random errors.
TEST_P(PixelMeasurement, BilinearNoiseIsTheCovarianceOfWhatIsNotLinear) {
  test::Random random(9);
  const Ekf filter = some_filter(random, GetParam());
  const State& x = filter.state();
  int compared = 0;
  for (int i = 0; i < static_cast<int>(x.landmarks.size()); ++i) {
    const Landmark& landmark = x.landmarks[static_cast<std::size_t>(i)];
    const Matrix2d noise = bilinear_noise(kCameras[0], filter, i, 0);
    if (!landmark.anchor) {
      EXPECT_EQ(noise, Matrix2d::Zero());
      continue;
    }
    const int anchor = x.clone(*landmark.anchor).row + 3, w = landmark.row + 2;
    std::vector<int> rows = {3, 4, 5, anchor, anchor + 1, anchor + 2, w};
    const MatrixXd P = filter.covariance()(rows, rows);
    const MatrixXd L = P.llt().matrixL();
    const auto pixel = [&](const VectorXd& e) -> Vector2d {
      VectorXd all = VectorXd::Zero(x.size());
      all(rows) = 0.02 * e;  // so small that the projection itself is linear
      const State y = test::moved(kStandardChart, x, all);
      return -measure_pixel(kCameras[0], 1, y, i, Vector2d::Zero())->residual;
    };
    Matrix2d sum = Matrix2d::Zero();
    constexpr int kDraws = 4000;
    for (int draw = 0; draw < kDraws; ++draw) {
      const VectorXd e = L * random.normal_vector(7);
      VectorXd way = e, depth = e;  // the error of one only
      way[6] = 0;
      depth.head<6>().setZero();
      const Vector2d product = pixel(e) - pixel(way) - pixel(depth) + pixel(VectorXd::Zero(7));
      sum += product * product.transpose() / kDraws;
    }
    // bilinear_noise neglects the change of the derivative by the point along the displacement: a
    // few tenths.
    const Matrix2d seen = sum / std::pow(0.02, 4);
    EXPECT_LT((seen - noise).norm(), 0.4 * noise.norm()) << seen << "\n" << noise;
    EXPECT_GT(seen.trace(), 0.7 * noise.trace());
    ++compared;
  }
  EXPECT_EQ(compared, 3);
}

// In the middle of the image the pixel has the variance of the walk.
TEST(DriftNoise, IsThatOfThePixelAndHasNoDepth) {
  constexpr double kVariance = 0.25;
  State x;
  const Camera& camera = kCameras[0];
  const SE3 world_T_cam = camera.cam_T_imu.inverse();
  x.landmarks.push_back({.id = 1, .p_world = world_T_cam * Vector3d(0, 0, 6), .row = 6});
  x.clones.push_back({.id = 3, .time = {}, .world_T_imu = {}, .row = 9});
  x.landmarks.push_back({.id = 2,
                         .row = 15,
                         .anchor = 3,
                         .cam_T_imu = camera.cam_T_imu,
                         .inverse_depth = {0, 0, 1.0 / 6}});
  for (int i = 0; i < 2; ++i) {
    const Landmark& landmark = x.landmarks[static_cast<std::size_t>(i)];
    const Matrix3d noise = drift_noise(camera, x, landmark, kVariance, 0);
    const auto z = measure_pixel(camera, 1, x, i, {camera.cx, camera.cy});
    ASSERT_TRUE(z);
    const MatrixXd pixel = z->d_landmark * noise * z->d_landmark.transpose();
    EXPECT_TRUE(test::agree(pixel, kVariance * Matrix2d::Identity(), 2e-2)) << pixel;
    const Vector3d depth = landmark.anchor ? Vector3d(0, 0, 1) : world_T_cam.R.col(2);
    EXPECT_NEAR(depth.dot(noise * depth), 0, 1e-12);
  }
}

// The walk of a track beside the camera is that of its pixel, too: a pixel is another angle there.
TEST(DriftNoise, BesideTheCameraIsThatOfThePixel) {
  constexpr double kVariance = 0.04;
  const Camera& camera = kCameras[2];
  State x;
  x.clones = {{.id = 1, .time = {}, .world_T_imu = {}, .row = 6}};
  for (const Vector2d& pixel : pixels_of(2)) {
    x.landmarks = {landmark_of(*initialise_anchored(camera, 1, x, 6, pixel, 0.3, 0.1, 2), 12)};
    if (x.landmarks.front().face == AnchorFace::kFront) continue;
    const Matrix3d noise = drift_noise(camera, x, x.landmarks.front(), kVariance, 2);
    const auto z = measure_pixel(camera, 1, x, 0, pixel, Linearisation::kCurrent, 2);
    ASSERT_TRUE(z);
    const MatrixXd of_pixel = z->d_landmark * noise * z->d_landmark.transpose();
    EXPECT_TRUE(test::agree(of_pixel, kVariance * Matrix2d::Identity(), 1e-9));
    EXPECT_EQ(noise(2, 2), 0);
  }
}

TEST(PixelMeasurementOfAPoint, BehindTheCameraThereIsNone) {
  State x;
  x.landmarks.push_back({.id = 1, .p_world = {-5, 0, 0}, .row = 6});
  EXPECT_FALSE(measure_pixel(kCameras[0], 1, x, 0, {600, 180}));
  // A lens that sees more than 90 degrees may have it, but not straight behind or too near.
  x.landmarks[0].p_world = {-2, 5, 0};
  EXPECT_FALSE(measure_pixel(kCameras[0], 1, x, 0, {600, 180}));
  EXPECT_TRUE(measure_pixel(kCameras[2], 1, x, 0, {600, 180}));
  x.landmarks[0].p_world = kCameras[2].cam_T_imu.inverse() * Vector3d(0, 0, -5);
  EXPECT_FALSE(measure_pixel(kCameras[2], 1, x, 0, {600, 180}));
  x.landmarks[0].p_world = kCameras[2].cam_T_imu.inverse() * Vector3d(0.05, 0, -0.05);
  EXPECT_FALSE(measure_pixel(kCameras[2], 1, x, 0, {600, 180}));
  x.landmarks[0].p_world = {5, 0, 0};
  EXPECT_TRUE(measure_pixel(kCameras[0], 1, x, 0, {600, 180}));
}

TEST_P(NewPixelLandmark, AtADepthHasTheDerivativesOfItsPosition) {
  test::Random random(2);
  for (int index = 0; index < 3; ++index) {
    const Camera& camera = kCameras[static_cast<std::size_t>(index)];
    const State x = some_filter(random, GetParam()).state();
    const VectorXd zero = VectorXd::Zero(x.size());
    for (const Vector2d& pixel : pixels_of(index)) {
      const auto position = [&](const VectorXd& e, const Vector3d& seen) -> VectorXd {
        const State y = test::moved(kStandardChart, x, e);
        return initialise_at_depth(camera, 1, y, 5, seen.head<2>(), seen.z(), 1, index)->p_world;
      };
      const auto initialised = initialise_at_depth(camera, 0.5, x, 5, pixel, 8, 3, index);
      ASSERT_TRUE(initialised);
      EXPECT_EQ(initialised->id, 5);
      const Vector2d again = pixel_of(camera_of(x, index), x.world_T_imu, initialised->p_world);
      EXPECT_LT((again - pixel).norm(), 1e-9);
      MatrixXd J = MatrixXd::Zero(3, x.size());
      J.leftCols<6>() = initialised->d_pose;
      for (const auto& six : initialised->clones) J.middleCols<6>(six.row) += six.d;
      const auto by_error = [&](const VectorXd& e) {
        return position(e, {pixel.x(), pixel.y(), 8});
      };
      EXPECT_TRUE(test::agree(J, test::numeric_derivative(by_error, zero), 1e-9));
      const auto by_seen = [&](const Vector3d& seen) { return position(zero, seen); };
      const MatrixXd D =
          test::numeric_derivative(by_seen, Vector3d(pixel.x(), pixel.y(), 8), kPixelStep);
      const Vector3d variances(0.25, 0.25, 9);
      EXPECT_TRUE(
          test::agree(initialised->noise, D * variances.asDiagonal() * D.transpose(), 1e-8, 0));
    }
  }
}

TEST_P(NewPixelLandmark, AnchoredIsTheRayAndTheInverseDepthThatIsGiven) {
  test::Random random(3);
  const State x = some_filter(random, GetParam()).state();
  for (int index = 0; index < 3; ++index) {
    const Camera& camera = kCameras[static_cast<std::size_t>(index)];
    for (const Vector2d& pixel : pixels_of(index)) {
      const auto initialised = initialise_anchored(camera, 0.5, x, 6, pixel, 0.3, 0.2, index);
      ASSERT_TRUE(initialised);
      EXPECT_EQ(initialised->id, 6);
      ASSERT_TRUE(initialised->anchor);
      EXPECT_EQ(*initialised->anchor, x.clones.back().id);
      EXPECT_TRUE(test::agree(initialised->cam_T_imu.inverse().p,
                              camera_of(x, index).cam_T_imu.inverse().p, 1e-14));
      EXPECT_TRUE(initialised->d_pose.isZero(0));  // it depends on the clone
      EXPECT_TRUE(initialised->clones.empty());

      State with = x;
      with.landmarks.push_back(landmark_of(*initialised, x.size()));
      // In the anchor's camera, the projection does not depend on the extrinsics: their error
      // cancels.
      const auto seen_again = [&](const VectorXd& e) -> VectorXd {
        const State y = test::moved(kStandardChart, with, e);
        return pixel_of(camera_of(y, index), y.clones.back().world_T_imu,
                        y.p_world(y.landmarks.back()));
      };
      const VectorXd zero = VectorXd::Zero(with.size());
      EXPECT_LT((seen_again(zero) - pixel).norm(), 1e-9);
      const MatrixXd by_error = test::numeric_derivative(seen_again, zero, kPixelStep);
      EXPECT_LT(by_error.leftCols(x.size()).cwiseAbs().maxCoeff(), 1e-6);
      const auto by_seen = [&](const Vector3d& seen) -> VectorXd {
        return initialise_anchored(camera, 1, x, 6, seen.head<2>(), seen.z(), 1)->inverse_depth;
      };
      const MatrixXd D =
          test::numeric_derivative(by_seen, Vector3d(pixel.x(), pixel.y(), 0.3), kPixelStep);
      const Vector3d variances(0.25, 0.25, 0.04);
      EXPECT_TRUE(
          test::agree(initialised->noise, D * variances.asDiagonal() * D.transpose(), 1e-9, 0));
    }
  }
}

TEST_P(NewPixelLandmark, NeedsARay) {
  test::Random random(4);
  const State x = test::random_state(random, {.clones = 1});
  const Vector2d beyond(5000, 5000);
  EXPECT_FALSE(initialise_at_depth(kCameras[2], 1, x, 1, beyond, 8, 1));
  EXPECT_FALSE(initialise_anchored(kCameras[2], 1, x, 1, beyond, 0.2, 0.1));
}

}  // namespace
}  // namespace chasles
