#include <map>

#include <chasles/filter/inertial_testing.hpp>
#include <chasles/loop/loop_matching.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;

// Landmarks 100, 102 and 104 have left the filter, and have not left another one.
struct LeftAndStayed {
  LeftAndStayed()
      : random(3),
        left(test::inertial_filter(
            kStandardChart, random, false, false,
            {.map = Ekf::Map::kPast, .past = {.recalls = true, .records = true}})),
        stayed(left) {
    int number = left.past().states();
    for (const std::size_t i : {0, 2, 4}) {
      const Landmark& landmark = stayed.state().landmarks[i];
      past[landmark.id] = {.number = number++, .p_nav = landmark.p_world};
    }
    left.retire(std::vector<int>{0, 2, 4});
    test::Random same(4), again(4);
    test::walk_on(left, same);
    test::walk_on(stayed, again);
    for (auto& [id, landmark] : past) {
      const int index = static_cast<int>(observed.size());
      candidates.push_back({.id = id, .past = &landmark, .like = {{0, index}}});
      const Eigen::Vector3d p_imu = left.state().world_T_imu.inverse() * landmark.p_nav;
      observed.push_back(
          {.id = index,
           .pixel = project(camera, camera.cam_T_imu * p_imu)->pixel + random.normal_vector(2)});
    }
  }

  Camera camera = test::inertial_cameras().front();
  test::Random random;
  Ekf left, stayed;
  PastLandmarks past;
  std::vector<LoopCandidate> candidates;
  std::vector<ObservedLandmark> observed;
};

// What the filter knows of past landmarks predicts the pixels as if they had stayed.
TEST(LoopMatching, InnovationsAreThoseOfLandmarksThatStayed) {
  LeftAndStayed x;
  const LoopInnovations found = loop_innovations(x.camera, x.left, x.candidates,
                                                 known_landmarks(x.left, x.candidates), x.observed);
  ASSERT_EQ(found.matches.size(), 3u);
  std::vector<Measurement> expected;
  for (int i = 0; i < 3; ++i) {
    const auto& pixel = x.observed[static_cast<std::size_t>(i)].pixel;
    expected.push_back(*measure_pixel(x.camera, 1, x.stayed.state(), 2 * i, pixel));
  }
  const auto dense = test::dense_measurement(x.stayed.state(), expected);
  const MatrixXd S = dense.H * x.stayed.covariance() * dense.H.transpose();
  EXPECT_TRUE(test::agree(found.r, dense.r, 1e-8));
  EXPECT_TRUE(test::agree(found.S, S, 1e-8));
}

// By a proposed place, whose errors the known landmarks share: numeric derivatives of the pixels.
TEST(LoopMatching, ThePlaceMovesThePixelsByItsDerivative) {
  LeftAndStayed x;
  KnownLandmarks known = known_landmarks(x.left, x.candidates);
  known.by_place.resize(9, 4);
  for (int j = 0; j < 4; ++j) known.by_place.col(j) = x.random.normal_vector(9);
  const LoopInnovations found = loop_innovations(x.camera, x.left, x.candidates, known, x.observed);
  const auto residuals = [&](const Eigen::VectorXd& e) -> Eigen::VectorXd {
    KnownLandmarks there = known;
    const Eigen::VectorXd move = known.by_place * e;
    for (int i = 0; i < 3; ++i) {
      there.landmarks[static_cast<std::size_t>(i)].p_world += move.segment<3>(3 * i);
    }
    return loop_innovations(x.camera, x.left, x.candidates, there, x.observed).r;
  };
  const Eigen::VectorXd none = Eigen::VectorXd::Zero(4);
  EXPECT_TRUE(test::agree(found.by_place, -test::numeric_derivative(residuals, none, 1e-4), 1e-6));
}

// Six pairs that agree are compatible at once and accepted from another place.
TEST(LoopMatching, MatchesAreAcceptedFromASecondPlace) {
  constexpr int kPairs = 6;
  PastLandmarks past;
  std::vector<LoopCandidate> candidates;
  std::vector<ObservedLandmark> observed;
  LoopInnovations innovations;
  for (int i = 0; i < kPairs; ++i) {
    past[i].p_nav = {10, i - 3.0, 0};
    observed.push_back({.id = 50 + i});
    innovations.matches.push_back({.observation = i, .landmark = i});
  }
  for (auto& [id, landmark] : past) candidates.push_back({.id = id, .past = &landmark});
  innovations.r = Eigen::VectorXd::Constant(2 * kPairs, 3);
  // The pose is wrong by ten pixels, which all pairs share, and each landmark by two.
  innovations.S =
      100 * MatrixXd::Ones(2 * kPairs, 2 * kPairs) + 4 * MatrixXd::Identity(2 * kPairs, 2 * kPairs);
  CompatibleMatches compatible;
  const auto accepted = [&](const Eigen::Vector3d& p_nav) {
    return accepted_matches(innovations, candidates, observed, p_nav, {}, compatible);
  };
  const AcceptedMatches first = accepted({0, 0, 0});
  EXPECT_TRUE(first.matches.empty());
  EXPECT_FALSE(first.recognised);
  EXPECT_EQ(compatible.size(), static_cast<std::size_t>(kPairs));
  EXPECT_FALSE(accepted({0.05, 0, 0}).recognised) << "nearly from the same place";
  const AcceptedMatches second = accepted({1, 0, 0});
  EXPECT_TRUE(second.recognised);
  EXPECT_FALSE(second.matches.empty());

  innovations.r[0] = innovations.r[2] = innovations.r[4] = 200;  // three do not agree any more
  EXPECT_FALSE(accepted({2, 0, 0}).recognised);
  EXPECT_TRUE(compatible.empty());
}

}  // namespace
}  // namespace chasles
