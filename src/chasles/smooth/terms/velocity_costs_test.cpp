#include <gtest/gtest.h>

#include <chasles/lie/small_matrices.hpp>
#include <chasles/smooth/batch/velocity_testing.hpp>
#include <chasles/smooth/terms/cost_testing.hpp>
#include <chasles/smooth/terms/velocity_costs_detail.hpp>

namespace chasles {
namespace {

using namespace smooth_detail;
using test::agree;
using test::Blocks;
using test::expect_numeric;
using test::Random;
using test::residual;

std::vector<double> pose_numbers(const SE3& world_T_imu) {
  std::vector<double> x(kPoseNumbers);
  write_pose(world_T_imu, x.data());
  return x;
}

std::vector<double> random_numbers(Random& random, int n) {
  const Eigen::VectorXd v = 0.3 * random.normal_vector(n);
  return {v.begin(), v.end()};
}

SE3 near_pose(Random& random) {
  return {.R = so3::exp(0.1 * random.normal_vector(3)), .p = 0.5 * random.normal_vector(3)};
}

template <int Rows>
StereoTerm<Rows> term(const StereoRig& rig, StereoRows rows) {
  const StereoNoise noise{.u = 0.7, .v = 0.9, .disparity = 0.4};
  return stereo_term<Rows>(rig, rows, noise, {510, 310, 480, 312});
}

class VelocityCosts : public test::OverCharts {
 protected:
  template <int Rows>
  void expect_of_pixels(StereoRows rows) {
    Random random(3);
    const StereoRig rig = test::drive_rig();
    const StereoTerm<Rows> t = term<Rows>(rig, rows);
    for (int trial = 0; trial < 5; ++trial) {
      const std::vector<double> view = pose_numbers(near_pose(random)),
                                from = pose_numbers(near_pose(random));
      expect_numeric(PointCost(t), {&chart(), {view, {9, random.normal(), random.normal()}}}, 1e-7);
      const std::vector<double> inverse_depth = {0.2 * random.normal(), 0.2 * random.normal(),
                                                 random.uniform(-0.05, 0.2)};
      expect_numeric(AnchoredCost(t), {&chart(), {view, from, inverse_depth}}, 1e-6);
      expect_numeric(AnchorCost(t), {&chart(), {inverse_depth}}, 1e-6);
    }
  }
};

TEST_P(VelocityCosts, OfTheStart) {
  Random random(1);
  VelocityStart start{
      .mean = {.world_T_imu = near_pose(random), .additive = random.normal_vector(4)},
      .whitening = *whitening_of(test::random_covariance(random, 10, 0.5))};
  expect_numeric(VelocityStartCost(start),
                 {&chart(), {pose_numbers(near_pose(random)), random_numbers(random, 4)}}, 1e-7);
}

TEST_P(VelocityCosts, OfMotion) {
  Random random(2);
  for (const bool state : {true, false}) {
    for (const bool others : {true, false}) {
      const BodyVelocityModel model{.velocity_state = state, .gyro_bias = others, .scale = others};
      const BodyVelocity held{
          .time = {}, .linear_imu = {4, 0.3, 0.1}, .angular_imu = {0.1, -0.2, 0.4}};
      BodyVelocityNoise noise;
      noise.sample_sigma.setConstant(2);
      noise.walk.setConstant(10);
      noise.gyro_bias_walk = noise.scale_walk = 1;
      const TwistLink link = twist_link(model, 0.5, held, noise);
      Blocks blocks{&chart(), {}};
      for (int i = 0; i < 2; ++i) {
        blocks.numbers.push_back(pose_numbers(near_pose(random)));
        if (model.size() > 0) blocks.numbers.push_back(random_numbers(random, model.size()));
      }
      expect_numeric(TwistCost(link), blocks, 1e-6);
      if (!state) continue;
      const VelocitySample sample{.keyframe = 0, .velocity = held, .noise = noise};
      expect_numeric(SampleCost(model, sample), {&chart(), {random_numbers(random, model.size())}},
                     1e-8);
      BodyVelocityModel level = model;
      level.level = true;
      expect_numeric(
          SampleCost(level, sample),
          {&chart(), {pose_numbers(near_pose(random)), random_numbers(random, level.size())}},
          1e-7);
    }
  }
}

TEST_P(VelocityCosts, OfALevelSampleHasNoValueWhereTheBodyLooksUp) {
  const BodyVelocityModel model{
      .velocity_state = true, .gyro_bias = false, .scale = false, .level = true};
  BodyVelocityNoise noise;
  noise.sample_sigma.setOnes();
  const VelocitySample sample{.keyframe = 0, .velocity = {}, .noise = noise};
  const std::vector<double> up =
      pose_numbers({.R = so3::exp(Eigen::Vector3d(0, -std::numbers::pi / 2, 0)), .p = {0, 0, 0}});
  const std::vector<double> additive(9);
  const double* x[] = {up.data(), additive.data()};
  double r[6];
  EXPECT_FALSE(SampleCost(model, sample).Evaluate(x, r, nullptr));
}

TEST_P(VelocityCosts, OfPixels) {
  expect_of_pixels<2>(StereoRows::kMean);
  expect_of_pixels<3>(StereoRows::kMeanDisparity);
  expect_of_pixels<4>(StereoRows::kAll);
}

INSTANTIATE_TEST_SUITE_P(Charts, VelocityCosts, ::testing::ValuesIn(test::all_charts()),
                         test::chart_test_name);

template <int Rows>
void expect_the_filters(StereoRows rows) {
  Random random(4);
  const StereoRig rig = test::drive_rig();
  const StereoNoise noise{.u = 0.7, .v = 0.9, .disparity = 0.4};
  const StereoObservation o{.landmark = 1, .pixels = {510, 310, 480, 312}};
  for (int trial = 0; trial < 10; ++trial) {
    State x;
    x.world_T_imu = near_pose(random);
    x.landmarks.push_back({.id = 1, .p_world = {random.uniform(3, 60), 1, -1}});
    const auto z = measure_stereo(rig, rows, noise, x, 0, o);
    const auto seen = stereo_term<Rows>(rig, rows, noise, o.pixels)
                          .see(x.world_T_imu, {.p_world = x.landmarks[0].p_world, .w = 1});
    ASSERT_TRUE(z && seen);
    const Eigen::VectorXd weight = z->noise.diagonal().cwiseSqrt().cwiseInverse();
    EXPECT_TRUE(agree(seen->residual, weight.asDiagonal() * -z->residual, 1e-12));
    EXPECT_TRUE(agree(seen->d_pose, weight.asDiagonal() * z->d_core, 1e-12));
    EXPECT_TRUE(agree(seen->d_point, weight.asDiagonal() * z->d_landmark, 1e-12));
  }
}

TEST(StereoTerms, AreTheFiltersMeasurement) {
  expect_the_filters<2>(StereoRows::kMean);
  expect_the_filters<3>(StereoRows::kMeanDisparity);
  expect_the_filters<4>(StereoRows::kAll);
}

TEST(StereoTerms, APointBehindTheCamerasCountsAndDoesNotPull) {
  const StereoRig rig = test::drive_rig();
  const Blocks behind{&kStandardChart, {pose_numbers({}), {-5, 0, 0}}};
  const PointCost cost(term<3>(rig, StereoRows::kMeanDisparity));
  EXPECT_EQ(residual(cost, behind), Eigen::Vector3d::Constant(kNotSeen));
  for (const Eigen::MatrixXd& J : test::jacobians(cost, behind)) EXPECT_TRUE(J.isZero(0));
}

}  // namespace
}  // namespace chasles
