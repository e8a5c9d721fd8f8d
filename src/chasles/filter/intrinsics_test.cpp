#include <chasles/filter/multi_view_start.hpp>
#include <chasles/filter/pixel_projection.hpp>
#include <chasles/filter/pixel_testing.hpp>

// Intrinsics as random constants of the state, with a rolling shutter.
namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using test::kPixelStep;

std::vector<Camera> some_cameras() {
  std::vector<Camera> cameras = test::kCameras;
  cameras[1].shutter = {.readout = 0.02, .direction = ReadoutDirection::kUp};
  cameras[2].shutter = {.readout = 0.03};
  return cameras;
}

// A filter with clones whose core has the intrinsics of the cameras, and landmarks ahead.
Ekf some_calibrating_filter(test::Random& random) {
  State x = test::random_state(random, {.velocity = true, .additive = 6});
  for (const Camera& camera : some_cameras()) {
    const SE3 off{so3::exp(0.02 * random.normal_vector(3)), 0.02 * random.normal_vector(3)};
    x.imu_T_camera.push_back(off * camera.cam_T_imu.inverse());
    Intrinsics one = intrinsics_of(camera);
    one.projection += random.normal_vector(4);
    x.intrinsics.push_back(one);
  }
  x.time_offset = 0.01;
  Ekf filter(kStandardChart, x, test::random_covariance(random, x.core_size(), 1e-3),
             {.map = Ekf::Map::kFrozen});
  for (int i = 0; i < 4; ++i) {
    filter.set_readout(test::some_motion(random));
    filter.clone_pose(i, from_seconds(0.3 * i));
    Prediction step{.world_T_imu = filter.state().world_T_imu,
                    .v_world = filter.state().v_world,
                    .additive = filter.state().additive,
                    .F = MatrixXd::Identity(x.core_size(), x.core_size()),
                    .Q = test::random_covariance(random, x.core_size(), 1e-3)};
    step.world_T_imu.p += 0.5 * random.normal_vector(3);
    filter.propagate(step);
  }
  filter.set_readout(test::some_motion(random));
  filter.clone_pose(4, from_seconds(1.5));
  return filter;
}

TEST(Intrinsics, AreThoseOfTheirCamera) {
  for (const Camera& camera : some_cameras()) {
    Intrinsics one = intrinsics_of(camera);
    one.projection[0] += 3;
    const Camera other = with_intrinsics(camera, one);
    EXPECT_EQ(other.fx, camera.fx + 3);
    EXPECT_EQ(other.coefficients, camera.coefficients);
    EXPECT_EQ(other.shutter.readout, camera.shutter.readout);
  }
  EXPECT_EQ(intrinsics_of(test::pinhole_camera()).blocks(), 1);
  EXPECT_EQ(intrinsics_of(test::euroc_camera()).blocks(), 2);
}

TEST(Intrinsics, ErrorsMoveTheStateAndBack) {
  test::Random random(3);
  const State x = some_calibrating_filter(random).state();
  VectorXd xi = 1e-3 * random.normal_vector(x.size());
  // Rows without a parameter move nothing.
  for (int i = 0; i < 3; ++i) {
    xi[*x.intrinsics_row(i) + 5] = 0;
    if (i == 0) xi[*x.intrinsics_row(i) + Intrinsics::kReadoutRow] = 0;
    const int used =
        static_cast<int>(x.intrinsics[static_cast<std::size_t>(i)].coefficients.size());
    for (int k = used; k < 6 * (x.intrinsics[static_cast<std::size_t>(i)].blocks() - 1); ++k) {
      xi[*x.intrinsics_row(i) + 6 + k] = 0;
    }
  }
  const State y = test::moved(kStandardChart, x, xi);
  EXPECT_TRUE(test::agree(local(kStandardChart, x, y), xi, 1e-12));
}

TEST(Intrinsics, APixelHasTheirDerivative) {
  test::Random random(4);
  State x = some_calibrating_filter(random).state();
  x.landmarks.push_back(
      {.id = 7, .p_world = x.world_T_imu * test::point_ahead(random, 8), .row = x.size()});
  const VectorXd zero = VectorXd::Zero(x.size());
  const std::vector<Camera> cameras = some_cameras();
  for (int index = 0; index < 3; ++index) {
    const auto measure = [&](const State& y) {
      return measure_pixel(cameras[static_cast<std::size_t>(index)], 1, y, 0, {211, 143},
                           Linearisation::kCurrent, index);
    };
    const auto z = measure(x);
    ASSERT_TRUE(z);
    const auto residual = [&](const VectorXd& e) -> VectorXd {
      return measure(test::moved(kStandardChart, x, e))->residual;
    };
    const MatrixXd H = test::dense_measurement(x, {*z}).H;
    EXPECT_TRUE(test::agree(-H, test::numeric_derivative(residual, zero, 1e-5), 1e-6)) << index;
    const int row = *x.intrinsics_row(index);
    EXPECT_GT(H.middleCols<4>(row).norm(), 1);
    EXPECT_EQ(H.col(row + Intrinsics::kReadoutRow).norm() > 0, index > 0);
  }
}

// The new landmark moves so that its pixel stays: what it depends on is in its derivative.
TEST(Intrinsics, ANewLandmarkKeepsItsPixel) {
  test::Random random(5);
  const Ekf filter = some_calibrating_filter(random);
  const State& x = filter.state();
  const std::vector<Camera> cameras = some_cameras();
  const Vector2d pixel(150, 301);
  for (int index = 0; index < 3; ++index) {
    const Camera& camera = cameras[static_cast<std::size_t>(index)];
    for (const bool anchored : {false, true}) {
      const auto fresh = anchored ? initialise_anchored(camera, 1, x, 9, pixel, 0.2, 0.1, index)
                                  : initialise_at_depth(camera, 1, x, 9, pixel, 5, 1, index);
      ASSERT_TRUE(fresh);
      State with = x;
      with.landmarks.push_back({.id = 9,
                                .p_world = fresh->p_world,
                                .row = x.size(),
                                .anchor = fresh->anchor,
                                .cam_T_imu = fresh->cam_T_imu,
                                .inverse_depth = fresh->inverse_depth,
                                .camera = index,
                                .imu_T_line = fresh->imu_T_line});
      MatrixXd D = MatrixXd::Zero(3, x.size());
      if (!anchored) D.leftCols<6>() = fresh->d_pose;
      for (const auto& block : fresh->clones) D.middleCols<6>(block.row) += block.d;
      const auto z = measure_pixel(camera, 1, with, 0, pixel, Linearisation::kCurrent, index);
      ASSERT_TRUE(z);
      EXPECT_LT(z->residual.norm(), 1e-8);
      // The pose is that of the clone, whose errors equal its own.
      MatrixXd H = test::dense_measurement(with, {*z}).H;
      const int clone = x.clones.back().row;
      H.leftCols<6>() += H.middleCols<6>(clone);
      H.middleCols<6>(clone).setZero();
      if (anchored) D.leftCols<6>() += D.middleCols<6>(clone);
      D.middleCols<6>(clone).setZero();
      const MatrixXd total = H.leftCols(x.size()) + H.rightCols<3>() * D;
      EXPECT_LT(total.cwiseAbs().maxCoeff(), 1e-6 * H.cwiseAbs().maxCoeff())
          << index << " " << anchored << "\n"
          << total;
    }
  }
}

TEST(Intrinsics, AStartOfSeveralViewsMovesWithThem) {
  test::Random random(6);
  const State x = some_calibrating_filter(random).state();
  const std::vector<Camera> cameras = some_cameras();
  const Vector3d p_world = x.world_T_imu * test::point_ahead(random, 8);
  std::vector<ClonedView> views;
  for (const Clone& clone : x.clones) {
    for (int index = 1; index < 3; ++index) {
      const Camera camera = as_estimated(cameras[static_cast<std::size_t>(index)], x, index);
      Vector2d pixel = test::pixel_of(camera, clone.world_T_imu, p_world);
      for (int i = 0; i < 20; ++i) {
        pixel = test::pixel_of(
            camera, clone.world_T_imu * clone.readout.after(line_delay(camera, pixel)), p_world);
      }
      views.push_back({.clone = clone.id, .camera = index, .pixel = pixel});
    }
  }
  for (const bool anchored : {false, true}) {
    const auto start = initialise_multi_view(cameras, {.sigma = 1}, x, 7, views, anchored);
    ASSERT_TRUE(start);
    MatrixXd D = MatrixXd::Zero(3, x.size());
    for (const auto& block : start->landmark.clones) D.middleCols<6>(block.row) += block.d;
    // In the axes of the anchor as it is by `x`.
    const auto parameters = [&](const VectorXd& e) -> VectorXd {
      const State y = test::moved(kStandardChart, x, e);
      const auto there = initialise_multi_view(cameras, {.sigma = 1}, y, 7, views, anchored);
      if (!anchored) return there->landmark.p_world;
      Landmark moved;
      moved.cam_T_imu = there->landmark.cam_T_imu;
      moved.inverse_depth = there->landmark.inverse_depth;
      const SE3& world_T_imu = y.clones.back().world_T_imu;
      const HomogeneousPoint point = homogeneous(y.clones.back(), moved);
      const SE3 imu_T_camera = y.imu_T_camera[2];
      const SE3 anchor_T_imu = (start->landmark.imu_T_line * imu_T_camera).inverse();
      const Vector3d q = anchor_T_imu * (world_T_imu.inverse() * Vector3d(point.p_world / point.w));
      return Vector3d(q.x(), q.y(), 1) / q.z();
    };
    const VectorXd zero = VectorXd::Zero(x.size());
    EXPECT_TRUE(test::agree(D, test::numeric_derivative(parameters, zero, 1e-5), 1e-5)) << anchored;
  }
}

// Considered rows keep their mean and their covariance; the covariance of the others is that of the
// gain without them: Joseph's form.
TEST(ConsideredRows, AreASchmidtKalmanUpdate) {
  test::Random random(7);
  const Ekf plain = some_calibrating_filter(random);
  const State& x = plain.state();
  std::vector<int> rows;
  for (int i = 0; i < 6 * x.intrinsics[0].blocks(); ++i) rows.push_back(*x.intrinsics_row(0) + i);
  const MatrixXd P = plain.covariance().topLeftCorner(x.core_size(), x.core_size());
  State core = x;
  core.clones.clear();
  Ekf filter(kStandardChart, core, P, {.map = Ekf::Map::kFrozen, .considered = rows});
  NewLandmark fresh;
  fresh.id = 3;
  fresh.p_world = core.world_T_imu * Vector3d(7, 1, -0.5);
  fresh.noise = 0.01 * Eigen::Matrix3d::Identity();
  filter.add({&fresh, 1});
  const MatrixXd before = filter.covariance();
  const State at = filter.state();
  const auto z = measure_pixel(some_cameras()[0], 1, at, 0, {300, 200}, Linearisation::kCurrent, 0);
  ASSERT_TRUE(z);
  const MatrixXd H = test::dense_measurement(at, {*z}).H;
  const MatrixXd S = H * before * H.transpose() + z->noise;
  MatrixXd K = before * H.transpose() * S.inverse();
  for (const int row : rows) K.row(row).setZero();
  const MatrixXd A = MatrixXd::Identity(before.rows(), before.rows()) - K * H;
  const MatrixXd expected = A * before * A.transpose() + K * z->noise * K.transpose();
  filter.update({&*z, 1});
  EXPECT_EQ(filter.state().intrinsics[0].projection, at.intrinsics[0].projection);
  EXPECT_NE(filter.state().world_T_imu.p, at.world_T_imu.p);
  const int n = at.motion_size();  // of which the change of the chart turns the covariance
  EXPECT_TRUE(
      test::agree(filter.covariance().bottomRightCorner(before.rows() - n, before.rows() - n),
                  expected.bottomRightCorner(before.rows() - n, before.rows() - n), 1e-9));
}

}  // namespace
}  // namespace chasles
