#include <map>

#include <chasles/base/error.hpp>
#include <chasles/eval/evaluation.hpp>
#include <chasles/eval/test_trajectories.hpp>

namespace chasles {
namespace {

// What evaluation_oracle.py computes with numpy and scipy over the same two trajectories:
//     /usr/bin/python3 src/chasles/eval/evaluation_oracle.py
struct Oracle {
  Alignment alignment;
  double rmse, mean, median, max, attitude;
};
const std::vector<Oracle> kOracle = {
    {Alignment::kRigid, 1.06794526349, 1.00689380131, 1.01616377544, 1.77129729513, 1.05867165467},
    {Alignment::kSimilarity, 1.04869688416, 0.992555846177, 1.03391860404, 1.57532414477,
     1.05867165184},
    {Alignment::kPositionYaw, 1.23745404559, 1.12485993261, 1.18410046548, 2.06676674575,
     0.622149809571},
    {Alignment::kFirstPose, 2.56169263345, 2.33896439349, 2.15749353997, 4.19587269648,
     0.843921280233}};
constexpr double kOracleScale = 0.996344700142;

// The optimiser of the oracle's alignments stops at about 1e-9 in their parameters.
constexpr double kTolerance = 1e-7;

constexpr std::size_t kPoses = 400;

Trajectory drifting_estimate() {
  Trajectory trajectory = test::helix(kPoses);
  for (std::size_t k = 0; k < kPoses; ++k) {
    const auto i = static_cast<double>(k);
    const Eigen::Vector3d theta(std::sin(0.2 * i), std::cos(0.13 * i), 0.002 * i);
    const Eigen::Vector3d drift(0.5 * std::sin(0.05 * i), 0.01 * i, 0.3 * std::cos(0.07 * i));
    SE3& pose = trajectory[k].pose;
    pose = {so3::exp(-0.01 * theta) * pose.R, 1.003 * pose.p - drift};
  }
  return trajectory;
}

std::vector<Matrix6d> growing_covariances() {
  std::vector<Matrix6d> covariances(1, Matrix6d::Zero());
  Vector6d sigma;
  sigma << 0.01, 0.02, 0.03, 0.5, 1, 2;
  for (std::size_t k = 1; k < kPoses; ++k) {
    const Vector6d grown = sigma * (1 + 0.001 * static_cast<double>(k));
    const Matrix6d correlation = 0.7 * Matrix6d::Identity() + 0.3 * Matrix6d::Ones();
    covariances.emplace_back(grown.asDiagonal() * correlation * grown.asDiagonal());
  }
  return covariances;
}

Evaluation evaluated(PoseError definition = PoseError::kStandard) {
  EvaluationOptions options;
  options.alignments.push_back(Alignment::kSimilarity);
  options.pose_error = definition;
  return evaluate(drifting_estimate(), test::helix(kPoses), growing_covariances(), options);
}

std::map<std::string, std::optional<double>> by_name(const Evaluation& evaluation) {
  const auto all = figures(evaluation);
  return {all.begin(), all.end()};
}

TEST(Evaluation, AbsoluteErrorsAgreeWithScipy) {
  const Evaluation result = evaluated();
  for (const Oracle& expected : kOracle) {
    const AbsoluteError* error = find(result, expected.alignment);
    ASSERT_NE(error, nullptr);
    EXPECT_NEAR(error->position_m.rmse, expected.rmse, kTolerance) << name(expected.alignment);
    EXPECT_NEAR(error->position_m.mean, expected.mean, kTolerance) << name(expected.alignment);
    EXPECT_NEAR(error->position_m.median, expected.median, kTolerance) << name(expected.alignment);
    EXPECT_NEAR(error->position_m.max, expected.max, kTolerance) << name(expected.alignment);
    EXPECT_NEAR(error->attitude_deg.rmse, expected.attitude, kTolerance)
        << name(expected.alignment);
  }
  EXPECT_NEAR(find(result, Alignment::kSimilarity)->transform.scale, kOracleScale, 1e-9);
}

TEST(Evaluation, RelativeErrorsAgreeWithScipy) {
  const Evaluation result = evaluated();
  const RelativeError& over_100m = result.over_distance.front();
  EXPECT_NEAR(over_100m.translation.mean, 0.843896448495, 1e-10);
  EXPECT_NEAR(over_100m.rotation.mean, 0.0102750078352, 1e-10);
  EXPECT_EQ(over_100m.translation.count, 38U);
  const RelativeError& over_800m = result.over_distance.back();
  EXPECT_NEAR(over_800m.translation.mean, 0.235128187251, 1e-10);
  EXPECT_NEAR(over_800m.rotation.mean, 0.000867569167219, 1e-10);
  EXPECT_EQ(over_800m.translation.count, 24U);
  EXPECT_NEAR(result.over_time[0].translation.mean, 0.480195161761, 1e-10);
  EXPECT_NEAR(result.over_time[0].rotation.mean, 0.794738981016, 1e-10);
  EXPECT_NEAR(result.over_time[1].translation.mean, 1.33601437802, 1e-10);
  EXPECT_NEAR(result.over_time[1].rotation.mean, 0.460041100414, 1e-10);
}

TEST(Evaluation, NeesAgreesWithScipyInEveryDefinition) {
  const std::vector<std::tuple<PoseError, double, double>> expected = {
      {PoseError::kStandard, 5.51213535622, 6.51200337488},
      {PoseError::kBodyTwist, 5.50187101512, 6.50296949431},
      {PoseError::kWorldTwist, 2.44719984687, 6.50296949431}};
  for (const auto& [definition, position, pose] : expected) {
    const Nees result = *evaluated(definition).nees;
    EXPECT_NEAR(result.position_summary.mean, position, 1e-8) << name(definition);
    EXPECT_NEAR(result.attitude_summary.mean, 0.753669812656, 1e-8) << name(definition);
    EXPECT_NEAR(result.pose_summary.mean, pose, 1e-8) << name(definition);
    EXPECT_EQ(result.pose_summary.skipped, 1U);
  }
}

TEST(Evaluation, FiguresCarryTheNamesOfTheSummary) {
  const auto figure = by_name(evaluated());
  EXPECT_NEAR(*figure.at("ate_m"), 1.06794526349, kTolerance);
  EXPECT_NEAR(*figure.at("ate_posyaw_m"), 1.23745404559, kTolerance);
  EXPECT_NEAR(*figure.at("ate_first_pose_m"), 2.56169263345, kTolerance);
  EXPECT_NEAR(*figure.at("attitude_deg"), 1.05867165467, kTolerance);
  EXPECT_NEAR(*figure.at("rpe_100m_percent"), 0.843896448495, kTolerance);
  EXPECT_NEAR(*figure.at("nees_position"), 5.51213535622, kTolerance);
  EXPECT_NEAR(*figure.at("nees_attitude"), 0.753669812656, kTolerance);
  EXPECT_NEAR(*figure.at("nees_pose"), 6.51200337488, kTolerance);
  EXPECT_EQ(*figure.at("within_3_sigma_x"), evaluated().nees->within_3_sigma.share[3]);
  EXPECT_EQ(*figure.at("within_3_sigma_rz"), evaluated().nees->within_3_sigma.share[2]);
}

TEST(Evaluation, WhatDoesNotApplyHasNoValue) {
  const Trajectory shortly = test::straight(20, 1.0);
  const Evaluation result = evaluate(shortly, shortly);
  const auto figure = by_name(result);
  EXPECT_FALSE(result.nees.has_value());
  EXPECT_FALSE(figure.at("rpe_100m_percent").has_value());
  EXPECT_FALSE(figure.at("nees_pose").has_value());
  EXPECT_FALSE(figure.at("within_3_sigma_rx").has_value());
  EXPECT_NEAR(figure.at("ate_m").value(), 0, 1e-12);
  EXPECT_EQ(to_text(result).find("nan"), std::string::npos) << to_text(result);
  EXPECT_EQ(to_text(result).find("NEES"), std::string::npos);
}

TEST(Evaluation, TheTextNamesEveryAlignmentAndLength) {
  const std::string text = to_text(evaluated());
  for (const char* expected :
       {"400 stamps compared", "SE(3)", "Sim(3)", "position + yaw", "first pose", "1.068", "800",
        "0.844", "position", "5.51", "within 3 sigma %"}) {
    EXPECT_NE(text.find(expected), std::string::npos) << expected << "\n" << text;
  }
}

TEST(Evaluation, NeedsACovarianceForEveryPose) {
  const std::vector<Matrix6d> few(3, Matrix6d::Identity());
  EXPECT_THROW(evaluate(test::helix(10), test::helix(10), few), InputError);
}

TEST(Evaluation, TakesAHundredThousandPosesInItsStride) {
  const Trajectory truth = test::helix(100000);
  const Evaluation result =
      evaluate(truth, truth, std::vector<Matrix6d>(100000, Matrix6d::Identity()));
  EXPECT_EQ(result.matched, 100000U);
  EXPECT_LT(result.absolute.front().position_m.max, 1e-6);
  EXPECT_LT(result.nees->pose_summary.mean, 1e-12);
}

}  // namespace
}  // namespace chasles
