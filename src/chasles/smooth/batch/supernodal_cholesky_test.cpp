#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/lie/testing.hpp>
#include <chasles/smooth/batch/batch.hpp>
#include <chasles/smooth/batch/supernodal_cholesky.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Sparse = Eigen::SparseMatrix<double>;

// Variables in blocks of three, of which random ones are tied, and one that stands alone.
MatrixXd random_blocks(int blocks, int ties, int seed) {
  test::Random random(seed);
  const int n = 3 * blocks + 1;
  MatrixXd H = 0.1 * MatrixXd::Identity(n, n);
  for (int tie = 0; tie < ties; ++tie) {
    MatrixXd J = MatrixXd::Zero(4, n);
    for (int end = 0; end < 2; ++end) {
      const int block = static_cast<int>(random.uniform(0, blocks - 1e-9));
      for (int i = 0; i < 12; ++i) J(i % 4, 3 * block + i / 4) = random.uniform(-1, 1);
    }
    H += J.transpose() * J;
  }
  return H;
}

Sparse lower_half(const MatrixXd& H) {
  const Sparse all = H.sparseView();
  return all.triangularView<Eigen::Lower>();
}

MatrixXd permuted(const SupernodalCholesky& cholesky, const MatrixXd& H) {
  MatrixXd result(H.rows(), H.cols());
  for (int i = 0; i < H.rows(); ++i) {
    for (int j = 0; j < H.cols(); ++j) result(cholesky.place(i), cholesky.place(j)) = H(i, j);
  }
  return result;
}

TEST(SupernodalCholesky, IsTheDenseFactorOfThePermutedMatrix) {
  for (int seed = 1; seed <= 6; ++seed) {
    const MatrixXd H = random_blocks(40, 100 + 20 * seed, seed);
    const SupernodalCholesky cholesky(lower_half(H));
    MatrixXd L = MatrixXd::Zero(H.rows(), H.cols());
    int columns = 0;
    for (const SupernodalCholesky::Node& node : cholesky.nodes()) {
      EXPECT_EQ(node.first, columns);
      columns += node.width;
      for (int c = 0; c < node.width; ++c) {
        EXPECT_EQ(cholesky.node_of(node.first + c), &node - cholesky.nodes().data());
        for (std::size_t r = static_cast<std::size_t>(c); r < node.rows.size(); ++r) {
          L(node.rows[r], node.first + c) = node.L(static_cast<Index>(r), c);
        }
      }
    }
    EXPECT_EQ(columns, H.rows());
    const MatrixXd dense = permuted(cholesky, H).llt().matrixL();
    EXPECT_TRUE(test::agree(L, dense, 1e-12));
    EXPECT_LT(cholesky.nodes().size(), 42u);  // the three columns of a block are in one
  }
}

TEST(SupernodalCholesky, Solves) {
  for (int seed = 1; seed <= 6; ++seed) {
    const MatrixXd H = random_blocks(40, 20 * seed, seed);
    test::Random random(seed);
    Eigen::VectorXd b(H.rows());
    for (double& x : b) x = random.uniform(-1, 1);
    const Eigen::VectorXd x = SupernodalCholesky(lower_half(H)).solve(b);
    EXPECT_TRUE(test::agree(MatrixXd(x), MatrixXd(H.lu().solve(b)), 1e-10));
  }
}

TEST(SupernodalCholesky, TakesNothing) {
  const SupernodalCholesky cholesky(Sparse(0, 0));
  EXPECT_TRUE(cholesky.nodes().empty());
  EXPECT_EQ(cholesky.solve(Eigen::VectorXd()).size(), 0);
}

TEST(SupernodalCholesky, RejectsWhatIsNotPositiveDefinite) {
  MatrixXd H = random_blocks(10, 20, 1);
  H(7, 7) = -1;
  EXPECT_THROW(SupernodalCholesky{lower_half(H)}, Error);
  H(7, 7) = std::nan("");
  EXPECT_THROW(SupernodalCholesky{lower_half(H)}, Error);
}

TEST(SupernodalCholesky, Stops) {
  const MatrixXd H = random_blocks(10, 20, 1);
  EXPECT_THROW((SupernodalCholesky{lower_half(H), [] { return true; }}), BatchStopped);
}

}  // namespace
}  // namespace chasles
