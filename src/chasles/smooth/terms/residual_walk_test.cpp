#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/smooth/terms/residual_walk.hpp>

namespace chasles {
namespace {

// 2000 tracks of 20 residuals, 0.05 s apart: white noise and a walk per square root of a second.
ResidualWalk tracks(double white, double walk, unsigned seed, double outlier = 0) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  ResidualWalk result;
  for (int track = 0; track < 2000; ++track) {
    std::vector<Eigen::VectorXd> residuals;
    Eigen::Vector2d at = Eigen::Vector2d::Zero();
    for (int i = 0; i < 20; ++i) {
      at += walk * std::sqrt(0.05) * Eigen::Vector2d(normal(random), normal(random));
      residuals.emplace_back(at + white * Eigen::Vector2d(normal(random), normal(random)));
      if (outlier > 0 && i % 5 == 0) residuals.back().array() += outlier;
    }
    for (std::size_t i = 2; i < residuals.size(); ++i) {
      result.add(residuals[i - 2], residuals[i - 1], residuals[i], 0.1);
    }
  }
  return result;
}

TEST(ResidualWalk, IsTheVarianceOfTheWalkBesideWhiteNoise) {
  EXPECT_NEAR(tracks(0, 0.3, 1).variance_rate(), 0.09, 0.005);
  EXPECT_NEAR(tracks(0.02, 0.3, 2).variance_rate(), 0.09, 0.005);
  EXPECT_NEAR(tracks(0.3, 0.6, 3).variance_rate(), 0.36, 0.15);
  EXPECT_LT(tracks(0, 0.3, 1).variance_rate(), 0.09) << "the lower end";
}

TEST(ResidualWalk, WhiteNoiseDoesNotWiden) {
  int widened = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    widened += tracks(0.7, 0, seed).covariance_factor() > 1 ? 1 : 0;
  }
  EXPECT_LE(widened, 1);
}

TEST(ResidualWalk, WidensByTheRate) {
  const ResidualWalk walk = tracks(0, 0.3, 4);
  EXPECT_NEAR(walk.covariance_factor(), 1 + kWideningSquare * walk.variance_rate() / 0.05, 1e-9);
  EXPECT_EQ(ResidualWalk().covariance_factor(), 1);
}

// Half as many views have half of the information that the walk takes away.
TEST(ResidualWalk, WidensLessWithFewerViews) {
  ResidualWalk rare;
  std::mt19937 random(6);
  std::normal_distribution<double> normal;
  for (int track = 0; track < 4000; ++track) {
    std::vector<Eigen::VectorXd> residuals;
    Eigen::Vector2d at = Eigen::Vector2d::Zero();
    for (int i = 0; i < 10; ++i) {
      at += 0.3 * std::sqrt(0.1) * Eigen::Vector2d(normal(random), normal(random));
      residuals.emplace_back(at);
    }
    for (std::size_t i = 2; i < residuals.size(); ++i) {
      rare.add(residuals[i - 2], residuals[i - 1], residuals[i], 0.2);
    }
  }
  EXPECT_NEAR((tracks(0, 0.3, 6).covariance_factor() - 1) / (rare.covariance_factor() - 1), 2,
              0.15);
}

TEST(ResidualWalk, NextViewIsOfTheSameCamera) {
  struct View {
    int camera;
  };
  const std::vector<View> views = {{0}, {1}, {1}, {0}};
  EXPECT_EQ(next_view(views, 0), 3u);
  EXPECT_EQ(next_view(views, 1), 2u);
  EXPECT_EQ(next_view(views, 2), 4u);
}

TEST(ResidualWalk, LeavesOutWhatIsNoTrack) {
  ResidualWalk walk;
  const Eigen::VectorXd zero = Eigen::Vector2d(0, 0), one = Eigen::Vector2d(1, 0);
  walk.add(zero, one, 2 * one, 2.1);
  walk.add(zero, one, 2 * one, 0);
  walk.add(zero, one, 2 * one, std::nan(""));
  walk.add(zero, one, std::nan("") * one, 0.1);
  walk.add(zero, one, 3 * one, 0.1);
  EXPECT_EQ(walk.variance_rate(), 0);
  // Every triple has a residual of 4.2 or more, or is one of three between two of them.
  EXPECT_NEAR(tracks(0, 0.3, 5, 3).variance_rate(), tracks(0, 0.3, 5).variance_rate(), 0.01);
}

}  // namespace
}  // namespace chasles
