#include <limits>

#include <Eigen/LU>

#include <chasles/filter/compression.hpp>
#include <chasles/filter/inertial_testing.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd random_rows(test::Random& random, Index rows, Index cols) {
  MatrixXd M(rows, cols);
  for (Index j = 0; j < cols; ++j) M.col(j) = random.normal_vector(static_cast<int>(rows));
  return M;
}

// Measurements of some clones each, with correlated noise. The residuals depend only on a common
// part of rank `rank`, as with a single camera, which observes neither scale nor position.
std::vector<Measurement> of_clones(test::Random& random, const State& x, int count, Index rank) {
  const auto clones = static_cast<Index>(x.clones.size());
  const MatrixXd common = random_rows(random, rank, 6 * clones);
  std::vector<Measurement> result;
  for (int i = 0; i < count; ++i) {
    const Index k = 1 + i % 6;
    const MatrixXd root = random_rows(random, k, k);
    const MatrixXd d = random_rows(random, k, rank) * common;
    Measurement z;
    z.residual = random.normal_vector(static_cast<int>(k));
    z.d_core.resize(k, 0);
    z.noise = root * root.transpose() + MatrixXd::Identity(k, k);
    for (Index c = 0; c < clones; ++c) {
      z.clones.push_back(
          {.row = x.clones[static_cast<std::size_t>(c)].row, .d = d.middleCols<6>(6 * c)});
    }
    // The same six errors twice.
    z.clones.push_back(z.clones.front());
    z.clones.front().d.setZero();
    result.push_back(z);
  }
  return result;
}

struct Scene {
  State x;
  Covariance covariance;
};

Scene scene(test::Random& random) {
  State x = test::random_state(
      random, {.velocity = true, .additive = 6, .landmarks = 2, .clones = 4, .anchored = true});
  return {.x = x, .covariance = Covariance(test::random_covariance(random, x.size(), 0.3))};
}

std::vector<const Measurement*> pointers(const std::vector<Measurement>& all) {
  std::vector<const Measurement*> result;
  for (const Measurement& z : all) result.push_back(&z);
  return result;
}

// Compared with the textbook matrices, with the full H and with the compressed one.
TEST(Compression, CorrectionCovarianceAndNisAreThoseOfAllRows) {
  test::Random random(1);
  for (const Index rank : {1, 17, 24}) {
    const auto [x, covariance] = scene(random);
    const auto measurements = of_clones(random, x, 40, rank);
    const auto z = test::dense_measurement(x, measurements);
    const MatrixXd P = covariance.all();
    const MatrixXd S = z.H * P * z.H.transpose() + z.R;
    const MatrixXd gain = P * z.H.transpose() * S.inverse();

    WhiteningScratch scratch;
    const auto all = pointers(measurements);
    ASSERT_TRUE(can_be_compressed(all, scratch));
    const auto whitened =
        whiten_compressed(all, covariance, MatrixXd(0, covariance.size()), scratch);
    ASSERT_TRUE(whitened);
    EXPECT_EQ(whitened->W.cols(), rank);
    EXPECT_TRUE(test::agree(whitened->W * whitened->w, gain * z.r, 1e-9));
    EXPECT_TRUE(
        test::agree(whitened->W * whitened->W.transpose(), gain * S * gain.transpose(), 1e-9));
    EXPECT_NEAR(whitened->nis, z.r.dot(S.ldlt().solve(z.r)), 1e-9 * z.r.squaredNorm());
  }
}

TEST(Compression, IsForMoreRowsThanErrorsAndForClonesAlone) {
  test::Random random(2);
  const auto [x, covariance] = scene(random);
  WhiteningScratch scratch;
  auto few = of_clones(random, x, 7, 24);  // 1 + 2 + … + 6 + 1 rows
  EXPECT_FALSE(can_be_compressed(pointers(few), scratch));
  auto many = of_clones(random, x, 8, 24);
  EXPECT_FALSE(can_be_compressed(pointers(many), scratch));  // 24 rows, 24 errors
  many = of_clones(random, x, 9, 24);
  EXPECT_TRUE(can_be_compressed(pointers(many), scratch));
  many[4].landmark = 0;
  EXPECT_FALSE(can_be_compressed(pointers(many), scratch));
}

TEST(Compression, WhatIsNoMeasurementGivesNone) {
  test::Random random(3);
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const auto [x, covariance] = scene(random);
  const auto good = of_clones(random, x, 20, 24);
  WhiteningScratch scratch;
  const auto is_usable = [&](auto&& spoil) {
    auto bad = good;
    spoil(bad[3]);
    return whiten_compressed(pointers(bad), covariance, MatrixXd(0, covariance.size()), scratch)
        .has_value();
  };
  EXPECT_TRUE(is_usable([](Measurement&) {}));
  EXPECT_FALSE(is_usable([](Measurement& z) { z.residual[0] = kNan; }));
  EXPECT_FALSE(is_usable([](Measurement& z) { z.clones[1].d(0, 0) = kNan; }));
  EXPECT_FALSE(is_usable([](Measurement& z) { z.noise(0, 0) = -1; }));
  EXPECT_FALSE(is_usable([](Measurement& z) { z.noise(0, 0) = kNan; }));
}

}  // namespace
}  // namespace chasles
