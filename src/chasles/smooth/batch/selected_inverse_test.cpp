#include <Eigen/LU>
#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/lie/testing.hpp>
#include <chasles/smooth/batch/selected_inverse.hpp>

namespace chasles {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

Sparse lower(const Eigen::MatrixXd& H) {
  const Sparse all = H.sparseView();
  return all.triangularView<Eigen::Lower>();
}

// Compares every entry that H has.
void expect_inverse(const Eigen::MatrixXd& H) {
  const SelectedInverse inverse(lower(H));
  const Eigen::MatrixXd dense = H.inverse();
  for (int i = 0; i < H.rows(); ++i) {
    for (int j = 0; j < H.cols(); ++j) {
      if (H(i, j) == 0) continue;
      EXPECT_NEAR(inverse(i, j), dense(i, j), 1e-10 * dense.cwiseAbs().maxCoeff());
    }
  }
}

// Keyframes in a row, and points that some of them observe.
Eigen::MatrixXd way(test::Random& random, int keyframes, int points) {
  const int n = 3 * (keyframes + points);
  Eigen::MatrixXd H = 0.1 * Eigen::MatrixXd::Identity(n, n);
  const auto tie = [&](int a, int b) {
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(4, n);
    J.middleCols(a, 3) = Eigen::MatrixXd::Random(4, 3);
    J.middleCols(b, 3) = Eigen::MatrixXd::Random(4, 3);
    H += J.transpose() * J;
  };
  for (int k = 0; k + 1 < keyframes; ++k) tie(3 * k, 3 * (k + 1));
  for (int i = 0; i < points; ++i) {
    const int first = static_cast<int>(random.uniform(0, keyframes - 4));
    for (int k = first; k < first + 4; ++k) tie(3 * k, 3 * (keyframes + i));
  }
  return H;
}

TEST(SelectedInverse, IsTheInverse) {
  test::Random random(1);
  srand(1);  // of Eigen's Random
  expect_inverse(Eigen::MatrixXd::Identity(5, 5) * 4);
  expect_inverse(Eigen::MatrixXd::Constant(1, 1, 2));
  const Eigen::MatrixXd A = Eigen::MatrixXd::Random(20, 20);
  expect_inverse(A * A.transpose() + Eigen::MatrixXd::Identity(20, 20));
  for (int trial = 0; trial < 5; ++trial) expect_inverse(way(random, 30, 40));
}

TEST(SelectedInverse, GivesBlocks) {
  test::Random random(2);
  const Eigen::MatrixXd H = way(random, 10, 6);
  const SelectedInverse inverse(lower(H));
  EXPECT_TRUE(test::agree(inverse.block({3, 4, 5, 6, 7, 8}),
                          Eigen::MatrixXd(H.inverse().block(3, 3, 6, 6)), 1e-10));
}

TEST(SelectedInverse, RejectsWhatHasNone) {
  Eigen::MatrixXd H = Eigen::MatrixXd::Identity(3, 3);
  H(1, 1) = 0;
  EXPECT_THROW(SelectedInverse{lower(H)}, Error);
  H(1, 1) = -1;
  EXPECT_THROW(SelectedInverse{lower(H)}, Error);
  H(1, 1) = std::nan("");
  EXPECT_THROW(SelectedInverse{lower(H)}, Error);
  const SelectedInverse diagonal(lower(Eigen::MatrixXd::Identity(3, 3)));
  EXPECT_THROW(diagonal(2, 0), Error);
}

}  // namespace
}  // namespace chasles
