#include <cmath>
#include <set>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

#include <chasles/lie/testing.hpp>
#include <chasles/loop/joint_compatibility.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

// Innovations that depend on a pose that is uncertain by 30 px, with 1 px of noise.
struct MatchScene {
  explicit MatchScene(int matches, std::uint64_t seed) : random(seed) {
    MatrixXd H(2 * matches, 3);
    for (double& h : H.reshaped()) h = random.normal();
    for (Index i = 0; i < matches; ++i) H.block<2, 2>(2 * i, 0).setIdentity();
    S = 900 * H * H.transpose() + MatrixXd::Identity(2 * matches, 2 * matches);
    r = 30 * H * random.normal_vector(3) + random.normal_vector(2 * matches);
    for (int i = 0; i < matches; ++i) proposed.push_back({.observation = i, .landmark = i});
  }
  // Well inside the ellipse of this match alone.
  void make_wrong(int i) { r.segment<2>(2 * Index{i}) = 30 * random.normal_vector(2); }

  test::Random random;
  std::vector<ProposedMatch> proposed;
  VectorXd r;
  MatrixXd S;
};

TEST(JointCompatibility, FindsTheMatchesThatAgree) {
  int missed = 0, wrong = 0;
  for (std::uint64_t seed = 0; seed < 50; ++seed) {
    MatchScene scene(16, seed);
    for (int i = 8; i < 16; ++i) scene.make_wrong(i);
    const JointMatches found = jointly_compatible(scene.proposed, scene.r, scene.S, 0.99);
    std::set<int> matches(found.matches.begin(), found.matches.end());
    for (int i = 0; i < 8; ++i) missed += !matches.contains(i);
    for (int i = 8; i < 16; ++i) wrong += matches.contains(i);
    EXPECT_LT(found.square, 60);
  }
  // 1 % of the right ones fail their own test, and a wrong one agrees by chance: (3 px / 30 px)^2.
  EXPECT_LT(missed, 20) << "of 400";
  EXPECT_LT(wrong, 12) << "of 400";
}

TEST(JointCompatibility, TheSquareIsThatOfAllMatchesTogether) {
  const MatchScene scene(5, 1);
  const JointMatches found = jointly_compatible(scene.proposed, scene.r, scene.S, 0.999);
  ASSERT_EQ(found.matches.size(), 5u);
  EXPECT_NEAR(found.square, scene.r.dot(scene.S.ldlt().solve(scene.r)), 1e-6);
}

TEST(JointCompatibility, TheSquareOfSomeMatchesLeavesTheOthersOut) {
  const MatchScene scene(5, 1);
  const Eigen::Matrix4d S = scene.S.bottomRightCorner<4, 4>() + 2 * Eigen::Matrix4d::Identity();
  const Eigen::Vector4d r = scene.r.tail<4>();
  EXPECT_NEAR(joint_square({3, 4}, scene.r, scene.S, 2), r.dot(S.ldlt().solve(r)), 1e-6);
}

TEST(JointCompatibility, AnObservationOrALandmarkIsMatchedOnce) {
  MatchScene scene(4, 2);
  scene.proposed[1].landmark = 0;
  scene.proposed[3].observation = 2;
  const JointMatches found = jointly_compatible(scene.proposed, scene.r, scene.S, 0.999);
  EXPECT_EQ(found.matches.size(), 2u);
}

// Two halves agree, each within itself: the pose decides for none of them.
TEST(JointCompatibility, CountsAnotherSetThatAgreesAsWell) {
  MatchScene scene(12, 3);
  scene.S = MatrixXd::Identity(24, 24) + 900 * MatrixXd::Identity(2, 2).replicate(12, 12);
  scene.r = scene.random.normal_vector(24);
  scene.r.tail(12).array() += 20;
  const JointMatches found = jointly_compatible(scene.proposed, scene.r, scene.S, 0.99);
  EXPECT_GE(found.matches.size(), 5u);
  EXPECT_GE(found.runner_up, 5);
}

TEST(JointCompatibility, WithoutMatchesThereIsNone) {
  const JointMatches found = jointly_compatible({}, VectorXd(0), MatrixXd(0, 0), 0.99);
  EXPECT_TRUE(found.matches.empty());
}

TEST(MostInformative, TakesWhatIsNotKnownFromOthers) {
  // The first two say the same, the third says little.
  MatrixXd A = MatrixXd::Zero(6, 4);
  A.block<2, 2>(0, 0) = A.block<2, 2>(2, 0) = 10 * MatrixXd::Identity(2, 2);
  A.block<2, 2>(4, 2) = 0.1 * MatrixXd::Identity(2, 2);
  const MatrixXd S = A * A.transpose() + MatrixXd::Identity(6, 6);
  const Informative found = most_informative({0, 1, 2}, S, 1, 1);
  EXPECT_EQ(found.matches, std::vector<int>{0});
  EXPECT_NEAR(found.nats, std::log(101.0), 1e-9);
  EXPECT_EQ(most_informative({0, 1, 2}, S, 1, 0.001).matches.size(), 3u);
}

}  // namespace
}  // namespace chasles
