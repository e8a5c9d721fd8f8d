#include <gtest/gtest.h>

#include <chasles/filter/testing.hpp>
#include <chasles/smooth/batch/smooth_testing.hpp>
#include <chasles/smooth/terms/cost_testing.hpp>

namespace chasles {
namespace {

using namespace smooth_detail;
using test::agree;
using test::Blocks;
using test::expect_numeric;
using test::jacobians;
using test::Random;
using test::residual;

std::vector<double> motion_numbers(const InertialState& state) {
  std::vector<double> x(kMotionNumbers);
  write_motion(state, x.data());
  return x;
}

std::vector<double> bias_numbers(const InertialState& s) {
  std::vector<double> x(s.accelerometer_bias.begin(), s.accelerometer_bias.end());
  x.insert(x.end(), s.gyroscope_bias.begin(), s.gyroscope_bias.end());
  return x;
}

InertialState random_motion(Random& random) {
  return {.world_T_imu = {.R = so3::exp(0.2 * random.normal_vector(3)),
                          .p = 0.3 * random.normal_vector(3)},
          .v_world = random.normal_vector(3),
          .accelerometer_bias = 0.1 * random.normal_vector(3),
          .gyroscope_bias = 0.05 * random.normal_vector(3)};
}

Camera fisheye(double aside) {
  Camera camera = test::small_camera(aside);
  camera.distortion = Distortion::kEquidistant;
  camera.coefficients = {-0.01, 0.02, -0.01, 0.003};
  return camera;
}

class CostFunctions : public test::OverCharts {};

TEST_P(CostFunctions, OfTheStart) {
  Random random(1);
  BatchGraph graph;
  graph.start = random_motion(random);
  graph.start_whitening =
      test::random_covariance(random, 15, 0.5).llt().matrixL().solve(Matrix15d::Identity());
  const InertialState at = random_motion(random);
  expect_numeric(StartCost(graph), {&chart(), {motion_numbers(at), bias_numbers(at)}}, 1e-7);
}

TEST_P(CostFunctions, OfSamples) {
  Random random(2);
  std::vector<ImuInterval> intervals;
  for (int i = 0; i < 8; ++i) {
    intervals.push_back({.tau = 0.01,
                         .specific_force_imu = Eigen::Vector3d(0, 0, 9.8) + random.normal_vector(3),
                         .angular_rate_imu = random.normal_vector(3)});
  }
  const ImuNoise noise{.accelerometer_noise_density = 0.5,
                       .accelerometer_random_walk = 0.5,
                       .gyroscope_noise_density = 0.5,
                       .gyroscope_random_walk = 0.5};
  const ImuLink link = imu_link(intervals, Vector6d::Zero(), noise);
  const InertialState now = random_motion(random), next = random_motion(random);
  expect_numeric(
      LinkCost(link, {0, 0, -kStandardGravity}),
      {&chart(),
       {motion_numbers(now), bias_numbers(now), motion_numbers(next), bias_numbers(next)}},
      1e-6);
}

TEST_P(CostFunctions, OfPixels) {
  Random random(3);
  const Camera anchor = fisheye(0), other = fisheye(0.2);
  const PixelTerm term{.camera = &other,
                       .cam_T_imu = other.cam_T_imu,
                       .of_anchor = anchor.cam_T_imu,
                       .pixel = {300, 200},
                       .sigma = 0.7};
  for (int trial = 0; trial < 10; ++trial) {
    const InertialState view = random_motion(random), from = random_motion(random);
    expect_numeric(PointCost(term),
                   {&chart(), {motion_numbers(view), {6, random.normal(), random.normal()}}}, 1e-7);
    const std::vector<double> inverse_depth = {0.2 * random.normal(), 0.2 * random.normal(),
                                               random.uniform(-0.1, 0.4)};
    expect_numeric(AnchoredCost(term),
                   {&chart(), {motion_numbers(view), motion_numbers(from), inverse_depth}}, 1e-6);
    expect_numeric(AnchorCost(term), {&chart(), {inverse_depth}}, 1e-6);
  }
  expect_numeric(InverseDepthCost(3), {&chart(), {{0.1, 0.2, 0.5}}}, 1e-9);
}

TEST_P(CostFunctions, BothFormsOfALandmarkAreSeenAtTheSamePixel) {
  Random random(4);
  const Camera anchor = fisheye(0), other = fisheye(0.2);
  const PixelTerm term{
      .camera = &other, .cam_T_imu = other.cam_T_imu, .of_anchor = anchor.cam_T_imu};
  const InertialState view = random_motion(random), from = random_motion(random);
  const Eigen::Vector3d a(0.1, -0.2, 0.25);
  const Eigen::Vector3d p =
      from.world_T_imu * (anchor.cam_T_imu.inverse() * (Eigen::Vector3d(a.x(), a.y(), 1) / a.z()));
  const Blocks anchored{&chart(),
                        {motion_numbers(view), motion_numbers(from), {a.x(), a.y(), a.z()}}};
  const Blocks cartesian{&chart(), {motion_numbers(view), {p.x(), p.y(), p.z()}}};
  EXPECT_TRUE(
      agree(residual(AnchoredCost(term), anchored), residual(PointCost(term), cartesian), 1e-10));
}

TEST_P(CostFunctions, APointBehindTheCameraCountsAndDoesNotPull) {
  const Camera camera = test::small_camera(0);
  const PixelTerm term{
      .camera = &camera, .cam_T_imu = camera.cam_T_imu, .of_anchor = camera.cam_T_imu};
  const Blocks behind{&chart(), {motion_numbers({}), {-5, 0, 0}}};
  EXPECT_EQ(residual(PointCost(term), behind), Eigen::Vector2d(kNotSeen, kNotSeen));
  for (const Eigen::MatrixXd& J : jacobians(PointCost(term), behind)) EXPECT_TRUE(J.isZero(0));
}

// A search would end at a point where the cost jumps, down or up.
TEST_P(CostFunctions, APointThatComesNearerCostsMoreAndMore) {
  Camera camera = test::small_camera(0);
  camera.cam_T_imu.p.setZero();
  const PixelTerm term{.camera = &camera,
                       .cam_T_imu = camera.cam_T_imu,
                       .of_anchor = camera.cam_T_imu,
                       .pixel = {camera.cx, camera.cy}};
  double before = 0;
  for (double depth = 1; depth > 2e-4; depth *= 0.8) {
    const Blocks near{&chart(), {motion_numbers({}), {depth, 0.01, 0}}};
    const Eigen::Vector2d r = residual(PointCost(term), near);
    EXPECT_GT(r.norm(), 1.2 * before) << depth << " m";
    EXPECT_LT(r.norm(), depth < 1 ? 1.3 * before : kNotSeen) << depth << " m";
    before = r.norm();
  }
  EXPECT_GT(before, 100 * kNotSeen);
}

INSTANTIATE_TEST_SUITE_P(Charts, CostFunctions, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

}  // namespace
}  // namespace chasles
