#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <chasles/filter/inertial_model.hpp>
#include <chasles/filter/pixel_measurement.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/lie/testing.hpp>

// Heading and position of the world are unobservable and must stay so when the estimates change.
// The directions N of the errors with H N = 0 and F N = N+ use the first estimates
// (docs/derivations.md, D54 to D57).

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;

Camera camera() {
  Camera camera;
  camera.fx = camera.fy = 480;
  camera.cx = 350;
  camera.cy = 270;
  camera.cam_T_imu.R << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  camera.cam_T_imu.p = {0.05, -0.02, 0.1};
  return camera;
}

// A clone, an anchored and a Cartesian landmark, all changed by updates since their initialisation.
State moved_state() {
  State x;
  x.v_world = Vector3d(1.1, 0.2, -0.1);
  x.additive = Eigen::VectorXd::Zero(InertialModel::kSize);
  x.world_T_imu = {so3::exp({0.02, -0.03, 0.1}), {1.5, 0.4, -0.1}};
  Clone clone;
  clone.id = 7;
  clone.world_T_imu = {so3::exp({0.01, 0.02, 0.05}), {0.1, -0.2, 0.05}};
  clone.first = {so3::exp({0.02, -0.01, 0.02}), {0.15, -0.1, 0.02}};
  clone.row = 15;
  x.clones.push_back(clone);
  Landmark anchored;
  anchored.id = 1;
  anchored.row = 21;
  anchored.anchor = clone.id;
  anchored.cam_T_imu = camera().cam_T_imu;
  anchored.inverse_depth = {0.1, -0.2, 0.12};
  x.landmarks.push_back(anchored);
  Landmark cartesian;
  cartesian.id = 2;
  cartesian.row = 24;
  cartesian.p_world = {8, 1, 0.5};
  cartesian.first = {7.5, 1.2, 0.4};
  x.landmarks.push_back(cartesian);
  return x;
}

// Columns: rotation of the world about the vertical, and translation.
MatrixXd unobservable(const State& x) {
  MatrixXd N = MatrixXd::Zero(27, 4);
  const Vector3d up = Vector3d::UnitZ();
  const auto point = [&](int row, const Vector3d& p) {
    N.block<3, 1>(row, 0) = up.cross(p);
    N.block<3, 3>(row, 1).setIdentity();
  };
  N.block<3, 1>(0, 0) = up;
  point(3, x.world_T_imu.p);
  N.block<3, 1>(6, 0) = up.cross(*x.v_world);
  N.block<3, 1>(15, 0) = up;
  point(18, x.clones[0].first.p);
  point(24, x.landmarks[1].first);
  return N;
}

MatrixXd dense(const Measurement& z, const State& x) {
  MatrixXd H = MatrixXd::Zero(z.residual.size(), 27);
  H.leftCols(z.d_core.cols()) = z.d_core;
  H.middleCols<3>(x.landmarks[static_cast<std::size_t>(z.landmark)].row) += z.d_landmark;
  for (const Measurement::OfClone& clone : z.clones) H.middleCols<6>(clone.row) += clone.d;
  return H;
}

TEST(FirstEstimates, NoMeasurementSeesTheWorldsHeadingOrPosition) {
  const State x = moved_state();
  const MatrixXd N = unobservable(x);
  for (int landmark : {0, 1}) {
    const Eigen::Vector2d pixel(300, 250);
    const auto now = measure_pixel(camera(), 1, x, landmark, pixel);
    const auto first =
        measure_pixel(camera(), 1, x, landmark, pixel, Linearisation::kFirstEstimates);
    ASSERT_TRUE(now && first);
    EXPECT_EQ(now->residual, first->residual);
    EXPECT_LT((dense(*first, x) * N).cwiseAbs().maxCoeff(), 1e-10) << landmark;
    EXPECT_GT((dense(*now, x) * N).cwiseAbs().maxCoeff(), 1e-2) << landmark;
  }
}

TEST(FirstEstimates, ThePredictionKeepsItSo) {
  State x = moved_state();
  const PredictedMotion before{.p_world = {1.4, 0.5, -0.2}, .v_world = {1.0, 0.3, 0.0}};
  const InertialModel model;
  const std::vector<ImuInterval> intervals(
      5,
      {.tau = 0.02, .specific_force_imu = {0.5, -0.3, 9.9}, .angular_rate_imu = {0.1, 0.2, 0.5}});
  Prediction next = predict(model, x, intervals);
  const auto lost = [&] {
    State after = x;
    after.world_T_imu = next.world_T_imu;
    after.v_world = next.v_world;
    State first = x;
    first.world_T_imu.p = before.p_world;
    first.v_world = before.v_world;
    const MatrixXd difference =
        next.F * unobservable(first).topRows(15) - unobservable(after).topRows(15);
    return difference.cwiseAbs().maxCoeff();
  };
  EXPECT_GT(lost(), 1e-3);
  use_first_estimates(model, x, 0.1, before, next);
  EXPECT_LT(lost(), 1e-12);
}

}  // namespace
}  // namespace chasles
