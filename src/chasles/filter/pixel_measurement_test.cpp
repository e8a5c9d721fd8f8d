#include <Eigen/LU>

#include <chasles/camera/triangulation.hpp>
#include <chasles/filter/inertial_testing.hpp>

namespace chasles {
namespace {

using Eigen::Matrix2d;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

// Pixels vary by hundreds over a radian: a smaller step for the numeric derivative.
constexpr double kStep = 1e-4;

const std::vector<Camera> kCameras = test::inertial_cameras();

Ekf some_filter(test::Random& random, bool calibrating) {
  return test::inertial_filter(kStandardChart, random, true, calibrating);
}

// A camera of the rig, where the state has it.
Camera camera_of(const State& x, int index) {
  return as_estimated(kCameras[static_cast<std::size_t>(index)], x, index);
}

Vector2d pixel_of(const Camera& camera, const SE3& world_T_imu, const Vector3d& p_world) {
  return project(camera, camera.cam_T_imu * (world_T_imu.inverse() * p_world))->pixel;
}

// Of known cameras, and of cameras whose places are estimated.
class PixelMeasurement : public testing::TestWithParam<bool> {};
class NewPixelLandmark : public testing::TestWithParam<bool> {};
class MultiViewStartTest : public testing::TestWithParam<bool> {};

std::string how(const testing::TestParamInfo<bool>& info) {
  return info.param ? "EstimatedCameras" : "KnownCameras";
}
INSTANTIATE_TEST_SUITE_P(Cameras, PixelMeasurement, testing::Bool(), how);
INSTANTIATE_TEST_SUITE_P(Cameras, NewPixelLandmark, testing::Bool(), how);
INSTANTIATE_TEST_SUITE_P(Cameras, MultiViewStartTest, testing::Bool(), how);

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
      EXPECT_TRUE(test::agree(-H, test::numeric_derivative(residual, zero, kStep), 1e-9));
      const auto& landmark = x.landmarks[static_cast<std::size_t>(i)];
      const Vector2d expected = pixel_of(camera_of(x, index), x.world_T_imu, x.p_world(landmark));
      EXPECT_TRUE(test::agree(z->residual, pixel - expected, 1e-12));
      EXPECT_TRUE(test::agree(z->noise, 0.49 * MatrixXd::Identity(2, 2), 1e-15));
      anchored += landmark.anchor ? 1 : 0;
    }
  }
  EXPECT_EQ(anchored, 9);
}

// A guessed depth that noise takes to infinity or beyond: the direction is seen all the same.
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
        if (!z) continue;  // does not look there
        ++seen;
        const auto residual = [&](const VectorXd& e) -> VectorXd { return measure(e)->residual; };
        const MatrixXd H = test::dense_measurement(x, {*z}).H;
        EXPECT_TRUE(test::agree(-H, test::numeric_derivative(residual, zero, kStep), 1e-9));
      }
    }
    EXPECT_GE(seen, 6) << inverse_depth;
  }
}

// Against drawn errors: what a pixel differs by from its linear prediction.
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
      VectorXd way = e, depth = e;  // the error of one alone
      way[6] = 0;
      depth.head<6>().setZero();
      const Vector2d product = pixel(e) - pixel(way) - pixel(depth) + pixel(VectorXd::Zero(7));
      sum += product * product.transpose() / kDraws;
    }
    // That the derivative by the point changes along the way is left out: some tenths.
    const Matrix2d seen = sum / std::pow(0.02, 4);
    EXPECT_LT((seen - noise).norm(), 0.4 * noise.norm()) << seen << "\n" << noise;
    EXPECT_GT(seen.trace(), 0.7 * noise.trace());
    ++compared;
  }
  EXPECT_EQ(compared, 3);
}

TEST(PixelMeasurementOfAPoint, BehindTheCameraThereIsNone) {
  State x;
  x.landmarks.push_back({.id = 1, .p_world = {-5, 0, 0}, .row = 6});
  EXPECT_FALSE(measure_pixel(kCameras[0], 1, x, 0, {600, 180}));
  x.landmarks[0].p_world.x() = 5;
  EXPECT_TRUE(measure_pixel(kCameras[0], 1, x, 0, {600, 180}));
}

TEST_P(NewPixelLandmark, AtADepthHasTheDerivativesOfItsPosition) {
  test::Random random(2);
  for (int index = 0; index < 3; ++index) {
    const Camera& camera = kCameras[static_cast<std::size_t>(index)];
    const State x = some_filter(random, GetParam()).state();
    const VectorXd zero = VectorXd::Zero(x.size());
    const Vector2d pixel(camera.cx + 90, camera.cy - 60);
    const auto position = [&](const VectorXd& e, const Vector3d& seen) -> VectorXd {
      const State y = test::moved(kStandardChart, x, e);
      return begin_at_depth(camera, 1, y, 5, seen.head<2>(), seen.z(), 1, index)->p_world;
    };
    const auto begun = begin_at_depth(camera, 0.5, x, 5, pixel, 8, 3, index);
    ASSERT_TRUE(begun);
    EXPECT_EQ(begun->id, 5);
    const Vector2d again = pixel_of(camera_of(x, index), x.world_T_imu, begun->p_world);
    EXPECT_LT((again - pixel).norm(), 1e-9);
    MatrixXd J = MatrixXd::Zero(3, x.size());
    J.leftCols<6>() = begun->d_pose;
    for (const auto& six : begun->clones) J.middleCols<6>(six.row) += six.d;
    const auto by_error = [&](const VectorXd& e) { return position(e, {pixel.x(), pixel.y(), 8}); };
    EXPECT_TRUE(test::agree(J, test::numeric_derivative(by_error, zero), 1e-9));
    const auto by_seen = [&](const Vector3d& seen) { return position(zero, seen); };
    const MatrixXd D = test::numeric_derivative(by_seen, Vector3d(pixel.x(), pixel.y(), 8), kStep);
    const Vector3d variances(0.25, 0.25, 9);
    EXPECT_TRUE(test::agree(begun->noise, D * variances.asDiagonal() * D.transpose(), 1e-8, 0));
  }
}

TEST_P(NewPixelLandmark, AnchoredIsTheRayAndTheInverseDepthThatItIsTold) {
  test::Random random(3);
  const State x = some_filter(random, GetParam()).state();
  for (int index = 0; index < 3; ++index) {
    const Camera& camera = kCameras[static_cast<std::size_t>(index)];
    const Vector2d pixel(camera.cx + 90, camera.cy - 60);
    const auto begun = begin_anchored(camera, 0.5, x, 6, pixel, 0.3, 0.2, index);
    ASSERT_TRUE(begun);
    EXPECT_EQ(begun->id, 6);
    ASSERT_TRUE(begun->anchor);
    EXPECT_EQ(*begun->anchor, x.clones.back().id);
    EXPECT_EQ(begun->cam_T_imu.p, camera_of(x, index).cam_T_imu.p);
    EXPECT_TRUE(begun->d_pose.isZero(0));  // it hangs on the clone
    EXPECT_TRUE(begun->clones.empty());

    State with = x;
    with.landmarks.push_back({.id = 6,
                              .row = x.size(),
                              .anchor = begun->anchor,
                              .cam_T_imu = begun->cam_T_imu,
                              .inverse_depth = begun->inverse_depth,
                              .camera = begun->camera});
    // The camera that saw it sees it there wherever it is: its own error does not matter.
    const auto seen_again = [&](const VectorXd& e) -> VectorXd {
      const State y = test::moved(kStandardChart, with, e);
      return pixel_of(camera_of(y, index), y.clones.back().world_T_imu,
                      y.p_world(y.landmarks.back()));
    };
    const VectorXd zero = VectorXd::Zero(with.size());
    EXPECT_LT((seen_again(zero) - pixel).norm(), 1e-9);
    const MatrixXd by_error = test::numeric_derivative(seen_again, zero, kStep);
    EXPECT_LT(by_error.leftCols(x.size()).cwiseAbs().maxCoeff(), 1e-6);
    const auto by_seen = [&](const Vector3d& seen) -> VectorXd {
      return begin_anchored(camera, 1, x, 6, seen.head<2>(), seen.z(), 1)->inverse_depth;
    };
    const MatrixXd D =
        test::numeric_derivative(by_seen, Vector3d(pixel.x(), pixel.y(), 0.3), kStep);
    const Vector3d variances(0.25, 0.25, 0.04);
    EXPECT_TRUE(test::agree(begun->noise, D * variances.asDiagonal() * D.transpose(), 1e-9, 0));
  }
}

TEST_P(NewPixelLandmark, NeedsARay) {
  test::Random random(4);
  const State x = test::random_state(random, {.clones = 1});
  const Vector2d beyond(5000, 5000);
  EXPECT_FALSE(begin_at_depth(kCameras[2], 1, x, 1, beyond, 8, 1));
  EXPECT_FALSE(begin_anchored(kCameras[2], 1, x, 1, beyond, 0.2, 0.1));
}

// A point seen from all clones, with the first camera, and with the third from the last clone too.
struct Tracked {
  Ekf filter;
  std::vector<ClonedView> views;
};

Tracked tracked(test::Random& random, bool calibrating, double pixel_noise, int views_of_each = 1) {
  Tracked result{some_filter(random, calibrating), {}};
  const State& x = result.filter.state();
  const Vector3d p_world = x.world_T_imu * test::point_ahead(random, 8);
  const auto look = [&](const Clone& clone, int camera) {
    const Vector2d pixel = pixel_of(camera_of(x, camera), clone.world_T_imu, p_world);
    result.views.push_back({.clone = clone.id,
                            .camera = camera,
                            .pixel = pixel + pixel_noise * random.normal_vector(2)});
  };
  for (int i = 0; i < views_of_each; ++i) {
    for (const Clone& clone : x.clones) look(clone, i % 3);
  }
  look(x.clones[0], 2);
  look(x.clones.back(), 2);
  return result;
}

std::optional<MultiViewStart> begin(const Tracked& t, bool anchored, double sigma = 0.8) {
  return begin_multi_view(kCameras, sigma, t.filter.state(), 7, t.views, anchored);
}

// The state with the landmark of a start behind it.
State with_landmark(const State& x, const NewLandmark& fresh) {
  State result = x;
  result.landmarks.push_back({.id = fresh.id,
                              .p_world = fresh.p_world,
                              .row = x.size(),
                              .anchor = fresh.anchor,
                              .cam_T_imu = fresh.cam_T_imu,
                              .inverse_depth = fresh.inverse_depth,
                              .camera = fresh.camera});
  return result;
}

// All views' residuals, and their H by all errors with the landmark's last: numerically.
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
  return {.r = residuals(zero), .H = -test::numeric_derivative(residuals, zero, kStep)};
}

TEST_P(MultiViewStartTest, RestSaysNothingOfTheLandmarkAndAllThatIsLeftOfTheClones) {
  test::Random random(5);
  for (const int views_of_each : {1, 4}) {
    for (const bool anchored : {false, true}) {
      const Tracked t = tracked(random, GetParam(), 1, views_of_each);
      const auto start = begin(t, anchored);
      ASSERT_TRUE(start);
      const Batch batch = batch_of(t, start->landmark);
      const Eigen::Index n = t.filter.state().size();
      const auto rest = test::dense_measurement(t.filter.state(), start->rest);
      EXPECT_EQ(start->rest_rows, batch.r.size() - 3);
      EXPECT_EQ(rest.r.size(), start->rest_rows);
      EXPECT_TRUE(
          test::agree(rest.R, 0.64 * MatrixXd::Identity(rest.R.rows(), rest.R.cols()), 1e-15));
      // What projects the landmark out of all rows.
      const MatrixXd H_f = batch.H.rightCols<3>();
      const MatrixXd H_x = batch.H.leftCols(n);
      const MatrixXd out = MatrixXd::Identity(H_f.rows(), H_f.rows()) -
                           H_f * (H_f.transpose() * H_f).inverse() * H_f.transpose();
      EXPECT_TRUE(test::agree(rest.H.transpose() * rest.H, H_x.transpose() * out * H_x, 1e-8));
      EXPECT_TRUE(test::agree(rest.H.transpose() * rest.r, H_x.transpose() * out * batch.r, 1e-8));
      EXPECT_NEAR(rest.r.squaredNorm(), batch.r.dot(out * batch.r), 1e-8);
    }
  }
}

// Each observation counts once, and none is lost: added and updated, the filter is where batch
// least squares of all rows with a flat prior of the landmark is.
TEST_P(MultiViewStartTest, LandmarkAndRestTogetherAreTheBatchSolution) {
  test::Random random(6);
  constexpr double kSigma = 0.8;
  for (const bool anchored : {false, true}) {
    Tracked t = tracked(random, GetParam(), 0.5, 3);
    const auto start = begin(t, anchored, kSigma);
    ASSERT_TRUE(start);
    const State before = with_landmark(t.filter.state(), start->landmark);
    const Batch batch = batch_of(t, start->landmark);
    const Eigen::Index n = t.filter.state().size();
    MatrixXd information = batch.H.transpose() * batch.H / (kSigma * kSigma);
    information.topLeftCorner(n, n) += t.filter.covariance().inverse();
    const MatrixXd P = information.inverse();
    const VectorXd delta = P * batch.H.transpose() * batch.r / (kSigma * kSigma);

    t.filter.add({&start->landmark, 1});
    ASSERT_FALSE(t.filter.update(start->rest).failed);
    const State expected = test::moved(kStandardChart, before, delta);
    EXPECT_LT(test::distance(t.filter.state(), expected), 1e-8);
    EXPECT_GT(test::distance(before, expected), 1e-3);
    EXPECT_LT(test::covariance_difference(t.filter.covariance(), P), 1e-8);
    EXPECT_EQ(t.filter.state().landmarks.back().observations, static_cast<int>(t.views.size()));
  }
}

// The least-squares point of the views, by Gauss and Newton from nearby.
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

// Where all views meet in the point, Gauss and Newton's derivatives are the exact ones.
TEST_P(MultiViewStartTest, DerivativesAreThoseOfTheLeastSquaresPoint) {
  test::Random random(7);
  const Tracked t = tracked(random, GetParam(), 0);
  const State& x = t.filter.state();
  const auto start = begin(t, false, 0.8);
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
      [&](const VectorXd& e) { return point_of(e, no_pixels); }, no_error, kStep);
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
  const Tracked t = tracked(random, GetParam(), 0.5);
  const auto cartesian = begin(t, false);
  const auto anchored = begin(t, true);
  ASSERT_TRUE(cartesian && anchored);
  ASSERT_TRUE(anchored->landmark.anchor);
  EXPECT_EQ(*anchored->landmark.anchor, t.views.back().clone);
  const State x = with_landmark(t.filter.state(), anchored->landmark);
  EXPECT_LT((x.p_world(x.landmarks.back()) - cartesian->landmark.p_world).norm(), 1e-11);

  // The same joint covariance of clones and position, whichever form begins.
  Ekf one = t.filter;
  Ekf other = t.filter;
  one.add({&cartesian->landmark, 1});
  other.add({&anchored->landmark, 1});
  other.make_cartesian(static_cast<int>(other.state().landmarks.size()) - 1);
  EXPECT_LT(test::covariance_difference(other.covariance(), one.covariance()), 1e-9);
}

TEST_P(MultiViewStartTest, ViewsThatDoNotMeetBeginNothing) {
  test::Random random(9);
  Tracked t = tracked(random, GetParam(), 0);
  t.views.resize(1);
  EXPECT_FALSE(begin(t, false));
}

}  // namespace
}  // namespace chasles
