#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include <chasles/frontend/two_view.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles::test {
namespace {

constexpr double kPixel = 1 / 458.0;  // [rad]

/// Points in front of a moving camera; some of them are outliers.
struct Scene {
  int points = 150;
  double wrong = 0;  ///< share of pairs whose second ray is moved at random
  Eigen::Vector3d translation{0.05, 0.02, 0.03};  ///< of the points in the new axes [m]
  Eigen::Vector3d rotation{0.1, -0.3, 0.2};
  double max_angle = 0.7;  ///< of a ray with the axis [rad]
  double noise = 0.2 * kPixel;
  std::uint64_t seed = 1;
};

struct Drawn {
  std::vector<RayPair> pairs;
  std::vector<char> right;
  Eigen::Matrix3d now_R_last;
};

Eigen::Vector3d moved(const Eigen::Vector3d& ray, double radius, Random& random) {
  return so3::exp(radius * random.axis().cross(ray).normalized()) * ray;
}

Drawn draw(const Scene& scene) {
  Random random(scene.seed);
  Drawn drawn{.pairs = {}, .right = {}, .now_R_last = so3::exp(scene.rotation)};
  for (int i = 0; i < scene.points; ++i) {
    const double angle = scene.max_angle * std::sqrt(random.uniform());
    const double around = random.uniform(-std::numbers::pi, std::numbers::pi);
    const Eigen::Vector3d ray(std::sin(angle) * std::cos(around),
                              std::sin(angle) * std::sin(around), std::cos(angle));
    const Eigen::Vector3d p_last = ray * random.uniform(1, 8);
    const Eigen::Vector3d p_now = drawn.now_R_last * p_last + scene.translation;
    Eigen::Vector3d now = p_now.normalized();
    now = moved(now, scene.noise * std::abs(random.normal()), random);
    const bool right = random.uniform() >= scene.wrong;
    if (!right) now = moved(now, kPixel * random.uniform(5, 40), random);
    drawn.pairs.push_back({.last = ray, .now = now});
    drawn.right.push_back(right ? 1 : 0);
  }
  return drawn;
}

/// Shares of the inliers that are kept, and of the outliers that are removed.
struct Shares {
  double kept = 0, thrown = 0;
};

Shares shares(const Drawn& drawn, const TwoView& motion) {
  double right = 0, kept = 0, thrown = 0;
  for (std::size_t i = 0; i < drawn.pairs.size(); ++i) {
    right += drawn.right[i];
    if (drawn.right[i] && motion.right[i]) kept += 1;
    if (!drawn.right[i] && !motion.right[i]) thrown += 1;
  }
  const double wrong = static_cast<double>(drawn.pairs.size()) - right;
  return {kept / right, wrong > 0 ? thrown / wrong : 1};
}

TwoViewPrior prior_of(const Drawn& drawn, const Eigen::Vector3d& error = {0, 0, 0}) {
  return {.now_R_last = so3::exp(error) * drawn.now_R_last,
          .trusted = true,
          .threshold = kPixel,
          .seed = 5};
}

/// 20 scenes, each share the mean over them.
Shares mean_shares(Scene scene, const Eigen::Vector3d& gyroscope_error, bool trusted = true) {
  Shares mean;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    scene.seed = seed;
    const Drawn drawn = draw(scene);
    TwoViewPrior prior = prior_of(drawn, gyroscope_error);
    if (!trusted) prior = {.threshold = kPixel, .seed = seed};
    const TwoView motion = find_motion(drawn.pairs, prior);
    EXPECT_TRUE(motion.decided);
    const Shares one = shares(drawn, motion);
    mean.kept += one.kept / 20;
    mean.thrown += one.thrown / 20;
  }
  return mean;
}

TEST(TwoView, OfThirtyPerCentWrongTracksThrowsOutNineTenthsAndKeepsTheRight) {
  const Shares result = mean_shares({.wrong = 0.3}, {0, 0, 0});
  EXPECT_GT(result.kept, 0.97);
  EXPECT_GT(result.thrown, 0.9);
}

TEST(TwoView, DoesSoWithABiasedGyroscope) {
  // 0.08 rad/s, EuRoC's, over 50 ms: 1.8 pixels.
  const Shares result = mean_shares({.wrong = 0.3}, {0.002, -0.003, 0.0015});
  EXPECT_GT(result.kept, 0.95);
  EXPECT_GT(result.thrown, 0.9);
}

TEST(TwoView, DoesSoWithoutAnyRotationGiven) {
  const Shares result = mean_shares({.wrong = 0.3}, {0, 0, 0}, false);
  EXPECT_GT(result.kept, 0.95);
  EXPECT_GT(result.thrown, 0.88);
}

TEST(TwoView, DoesSoWithAGyroscopeThatIsPlainlyWrong) {
  const Shares result = mean_shares({.wrong = 0.2}, {0.03, -0.05, 0.02});
  EXPECT_GT(result.kept, 0.95);
  EXPECT_GT(result.thrown, 0.88);
}

TEST(TwoView, OfAFisheyeDoesSoToo) {
  const Shares result = mean_shares({.wrong = 0.3, .max_angle = 1.5}, {0.001, 0.001, -0.001});
  EXPECT_GT(result.kept, 0.95);
  EXPECT_GT(result.thrown, 0.9);
}

TEST(TwoView, OfAPureRotationKeepsEverythingThatTheRotationExplains) {
  for (const bool trusted : {true, false}) {
    const Shares clean = mean_shares({.translation = {0, 0, 0}}, {0, 0, 0}, trusted);
    EXPECT_GT(clean.kept, 0.995);
    const Shares mixed = mean_shares({.wrong = 0.3, .translation = {0, 0, 0}}, {0, 0, 0}, trusted);
    EXPECT_GT(mixed.kept, 0.97);
    EXPECT_GT(mixed.thrown, 0.85);
  }
}

TEST(TwoView, OfAStaticRigKeepsExactCopies) {
  Drawn drawn = draw({.translation = {0, 0, 0}, .rotation = {0, 0, 0}, .noise = 0});
  for (RayPair& pair : drawn.pairs) pair.now = pair.last;
  const TwoView motion = find_motion(drawn.pairs, prior_of(drawn));
  EXPECT_EQ(shares(drawn, motion).kept, 1);
  EXPECT_TRUE(motion.now_R_last.isApprox(drawn.now_R_last, 1e-9));
}

TEST(TwoView, FindsTheDirectionOfTheTranslationAndTheGyroscopesError) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const Scene scene{.wrong = 0.2, .noise = 0.05 * kPixel, .seed = seed};
    const Drawn drawn = draw(scene);
    const TwoView motion = find_motion(drawn.pairs, prior_of(drawn, {0.002, -0.002, 0.002}));
    EXPECT_GT(motion.t_now.dot(scene.translation.normalized()), std::cos(0.05));
    EXPECT_LT(so3::log(motion.now_R_last * drawn.now_R_last.transpose()).norm(), 8e-4);
  }
}

TEST(TwoView, DistanceIsFromTheHalfCircleTowardsTheTranslation) {
  const Eigen::Vector3d r(0, 0, 1), t(1, 0, 0);
  const auto ray = [](double x, double y) { return Eigen::Vector3d(x, y, 1).normalized(); };
  EXPECT_NEAR(half_circle_distance(r, ray(0.1, 0), t), 0, 1e-12);
  EXPECT_NEAR(half_circle_distance(r, ray(0.1, 0.01), t), 0.01, 1e-4);
  EXPECT_NEAR(half_circle_distance(r, ray(-0.1, 0), t), 0.1, 1e-3);
  EXPECT_NEAR(half_circle_distance(r, ray(0.1, 0), -t), 0.1, 1e-3);
  EXPECT_NEAR(half_circle_distance(r, r, t), 0, 1e-12);
  EXPECT_NEAR(half_circle_distance(t, ray(1e9, 1e7), t), 0.01, 1e-4);  // at the epipole
}

TEST(TwoView, OfFewPairsDecidesNothing) {
  for (const int points : {0, 1, 2, 7}) {
    const Drawn drawn = draw({.points = points, .wrong = 0.5});
    const TwoView motion = find_motion(drawn.pairs, prior_of(drawn));
    EXPECT_FALSE(motion.decided);
    EXPECT_EQ(motion.right, std::vector<char>(drawn.pairs.size(), 1));
    EXPECT_TRUE(motion.now_R_last.allFinite());
  }
}

TEST(TwoView, WithoutAgreementDecidesNothing) {
  const Drawn drawn = draw({.wrong = 1.0});
  const TwoView motion = find_motion(drawn.pairs, prior_of(drawn));
  EXPECT_FALSE(motion.decided);
  EXPECT_EQ(motion.right, std::vector<char>(drawn.pairs.size(), 1));
}

TEST(TwoView, ShowsTheSameTwice) {
  const Drawn drawn = draw({.wrong = 0.3});
  const TwoView a = find_motion(drawn.pairs, prior_of(drawn));
  const TwoView b = find_motion(drawn.pairs, prior_of(drawn));
  EXPECT_EQ(a.right, b.right);
  EXPECT_EQ(a.t_now, b.t_now);
  EXPECT_EQ(a.now_R_last, b.now_R_last);
}

}  // namespace
}  // namespace chasles::test
