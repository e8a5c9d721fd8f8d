#include <algorithm>

#include <gtest/gtest.h>

#include <chasles/imu/imu_correction.hpp>
#include <chasles/imu/imu_correction_testing.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

// Of every combination of groups.
std::vector<ImuCorrection> some_corrections(test::Random& random) {
  std::vector<ImuCorrection> result;
  for (int groups = 1; groups < 8; ++groups) {
    ImuCorrection one{.has_scale = (groups & 1) != 0,
                      .has_misalignment = (groups & 2) != 0,
                      .has_g_sensitivity = (groups & 4) != 0};
    one.add(0.1 * random.normal_vector(one.size()));
    result.push_back(one);
  }
  return result;
}

TEST(ImuCorrection, ParametersAreThoseThatWereAdded) {
  test::Random random(1);
  for (ImuCorrection one : some_corrections(random)) {
    const VectorXd before = one.parameters(), more = random.normal_vector(one.size());
    ASSERT_EQ(before.size(), one.size());
    ASSERT_EQ(static_cast<int>(one.names().size()), one.size());
    one.add(more);
    EXPECT_LT((one.parameters() - before - more).norm(), 1e-15);
  }
}

TEST(ImuCorrection, ItsMatricesAreThoseThatAreNamed) {
  ImuCorrection all;
  ASSERT_EQ(all.size(), 24);
  const auto with = [&](const std::string& name) {
    ImuCorrection one;
    const auto names = all.names();
    const auto at = std::find(names.begin(), names.end(), name);
    EXPECT_NE(at, names.end()) << name;
    VectorXd errors = VectorXd::Zero(24);
    errors[at - names.begin()] = 0.5;
    one.add(errors);
    return one;
  };
  EXPECT_EQ(with("accelerometer_scale_z").force(2, 2), 0.5);
  EXPECT_EQ(with("accelerometer_misalignment_z_x").force(2, 0), 0.5);
  EXPECT_EQ(with("gyroscope_scale_y").rate(1, 1), 0.5);
  EXPECT_EQ(with("gyroscope_misalignment_x_z").rate(0, 2), 0.5);
  EXPECT_EQ(with("g_sensitivity_y_z").rate_of_force(1, 2), 0.5);
  all.add(VectorXd::Ones(24));
  EXPECT_TRUE(
      all.force.isApprox(Eigen::Matrix3d(Eigen::Matrix3d::Ones().triangularView<Eigen::Lower>())));
  EXPECT_EQ(all.rate, Eigen::Matrix3d::Ones());
  EXPECT_EQ(all.rate_of_force, Eigen::Matrix3d::Ones());
}

TEST(ImuCorrection, ASampleIsWhatTheEquationsSay) {
  ImuCorrection one;
  one.force(2, 1) = 0.01;
  one.rate(0, 2) = -0.02;
  one.rate_of_force(1, 2) = 1e-3;
  const ImuSample sample = corrected(
      one, ImuSample{.specific_force_imu = {1, 2, 10}, .angular_rate_imu = {0.1, 0.2, 0.5}});
  EXPECT_TRUE(test::agree(sample.specific_force_imu, Vector3d(1, 2, 10.02), 1e-14));
  EXPECT_TRUE(test::agree(sample.angular_rate_imu, Vector3d(0.09, 0.2 - 1.002e-2, 0.5), 1e-14));
}

TEST(ImuCorrection, UndoesWhatTheImuDoes) {
  test::Random random(2);
  for (const ImuCorrection& one : some_corrections(random)) {
    const ImuSample sample{.specific_force_imu = random.normal_vector(3),
                           .angular_rate_imu = random.normal_vector(3)};
    const ImuSample same = corrected(one, test::as_measured(one, sample));
    EXPECT_LT((same.specific_force_imu - sample.specific_force_imu).norm(), 1e-13);
    EXPECT_LT((same.angular_rate_imu - sample.angular_rate_imu).norm(), 1e-13);
  }
}

TEST(ImuCorrection, DerivativeIsThatOfASample) {
  test::Random random(3);
  for (const ImuCorrection& one : some_corrections(random)) {
    const Vector3d force = 5 * random.normal_vector(3), rate = random.normal_vector(3);
    const auto sample_of = [&](const VectorXd& errors) -> VectorXd {
      ImuCorrection other = one;
      other.add(errors);
      const ImuInterval interval =
          corrected(other, ImuInterval{.specific_force_imu = force, .angular_rate_imu = rate});
      return (VectorXd(6) << interval.specific_force_imu, interval.angular_rate_imu).finished();
    };
    const VectorXd zero = VectorXd::Zero(one.size());
    EXPECT_TRUE(test::agree(Eigen::MatrixXd(one.derivative(force, rate)),
                            test::numeric_derivative(sample_of, zero, 1e-3), 1e-9));
  }
}

TEST(ImuCorrection, MarksWhatWasSaturatedAsMeasured) {
  ImuCorrection one;
  one.force(0, 0) = one.rate(1, 1) = -0.01;
  const ImuRange range{.accelerometer = 20, .gyroscope = 5};
  const ImuSample sample =
      corrected(one, range, {.specific_force_imu = {20, 0, 9}, .angular_rate_imu = {0, 4.99, 0}});
  EXPECT_TRUE(sample.force_clipped);
  EXPECT_LT(sample.specific_force_imu.x(), 20);
  EXPECT_FALSE(sample.rate_clipped);
}

}  // namespace
}  // namespace chasles
