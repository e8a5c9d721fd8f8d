#include <array>
#include <limits>
#include <thread>
#include <vector>

#include <Eigen/Cholesky>

#include <chasles/filter/dense.hpp>
#include <chasles/filter/testing.hpp>
#include <chasles/lie/testing.hpp>

namespace chasles {
namespace {

using Eigen::Lower;
using Eigen::MatrixXd;

constexpr double kDenseTolerance = 1e-12;
constexpr double kUntouched = 1e30;  // marks entries that an operation must neither read nor write

MatrixXd random_dense(test::Random& random, Eigen::Index rows, Eigen::Index cols) {
  MatrixXd M(rows, cols);
  for (auto column : M.colwise()) column = random.normal_vector(rows);
  return M;
}

MatrixXd lower(const MatrixXd& M) { return M.triangularView<Lower>(); }

// Calls check(matrix, a block of a larger one with the same numbers) for sizes around the tile's.
template <typename Check>
void for_each_size(Check check) {
  test::Random random(1);
  for (const int n : {0, 1, 2, 31, 32, 33, 70, 150}) {
    SCOPED_TRACE(n);
    MatrixXd large = MatrixXd::Constant(n + 5, n + 3, kUntouched);
    const MatrixXd M = test::random_covariance(random, n, 1);
    large.block(2, 1, n, n) = M;
    check(M, large.block(2, 1, n, n), random);
    large.block(2, 1, n, n).setConstant(kUntouched);
    EXPECT_EQ(large, MatrixXd::Constant(n + 5, n + 3, kUntouched));
  }
}

TEST(Dense, CholeskyFactorTimesItsTransposeIsTheMatrix) {
  for_each_size([](const MatrixXd& M, auto block, test::Random&) {
    block.template triangularView<Eigen::StrictlyUpper>().setConstant(kUntouched);
    ASSERT_TRUE(dense::cholesky(block));
    const MatrixXd L = lower(block);
    EXPECT_TRUE(test::agree(L * L.transpose(), M, kDenseTolerance));
    const MatrixXd upper = block.template triangularView<Eigen::StrictlyUpper>();
    MatrixXd expected = MatrixXd::Constant(M.rows(), M.cols(), kUntouched);
    EXPECT_EQ(upper, MatrixXd(expected.triangularView<Eigen::StrictlyUpper>()));
  });
}

TEST(Dense, CholeskyRejectsWhatIsNotPositiveDefinite) {
  MatrixXd indefinite = MatrixXd::Identity(3, 3);
  indefinite(2, 2) = -1e-3;
  EXPECT_FALSE(dense::cholesky(indefinite));
  for (const double wrong :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
        -std::numeric_limits<double>::infinity()}) {
    for (int n : {3, 200}) {
      for (const auto& [i, j] : {std::pair(0, 0), {1, 1}, {n - 1, n - 1}, {1, 0}, {n - 1, n - 2}}) {
        MatrixXd S = MatrixXd::Identity(n, n);
        S(i, j) = wrong;
        EXPECT_FALSE(dense::cholesky(S)) << wrong << " at " << i << ", " << j << " of " << n;
      }
    }
  }
}

TEST(Dense, PivotedCholeskyShowsTheRankAndTheFactor) {
  test::Random random(9);
  for (const int rank : {0, 1, 5, 12}) {
    MatrixXd A(40, 12);
    A.setZero();
    for (int i = 0; i < rank; ++i)
      A += random.normal_vector(40) * random.normal_vector(12).transpose();
    MatrixXd S = MatrixXd::Zero(12, 12);
    dense::square_lower(A, S);
    EXPECT_TRUE(S.triangularView<Eigen::StrictlyUpper>().toDenseMatrix().isZero(0));
    std::vector<int> order;
    Scratch workspace;
    ASSERT_EQ(dense::pivoted_cholesky(S, order, workspace), rank);
    const MatrixXd L = S.leftCols(rank).triangularView<Eigen::Lower>();
    const MatrixXd LLt = L * L.transpose(), AtA = A.transpose() * A;
    for (int i = 0; i < 12; ++i) {
      for (int j = 0; j < 12; ++j) {
        const auto row = order[static_cast<std::size_t>(i)];
        const auto col = order[static_cast<std::size_t>(j)];
        EXPECT_NEAR(LLt(i, j), AtA(row, col), 1e-10 * (1 + AtA.norm()));
      }
    }
  }
}

TEST(Dense, TriangularSolvesInvertTheFactor) {
  for_each_size([](const MatrixXd& M, auto block, test::Random& random) {
    const Eigen::Index n = M.rows();
    const MatrixXd L = M.llt().matrixL();
    block = L;
    MatrixXd X = random_dense(random, n, 3);
    const MatrixXd right = X;
    dense::solve_lower(block, X);
    EXPECT_TRUE(test::agree(L * X, right, kDenseTolerance));
    MatrixXd Y = right.transpose();
    dense::solve_lower_from_right(block, Y);
    EXPECT_TRUE(test::agree(Y * L.transpose(), right.transpose(), kDenseTolerance));
  });
}

TEST(Dense, RankUpdatesChangeTheLowerTriangleAlone) {
  for_each_size([](const MatrixXd& M, auto block, test::Random& random) {
    const Eigen::Index n = M.rows();
    const MatrixXd W = random_dense(random, n, 4);
    const MatrixXd Z = random_dense(random, n, 4);
    const MatrixXd upper = M.triangularView<Eigen::StrictlyUpper>();
    dense::downdate_lower(W, block);
    EXPECT_TRUE(test::agree(lower(block), lower(M - W * W.transpose()), kDenseTolerance));
    EXPECT_EQ(MatrixXd(block.template triangularView<Eigen::StrictlyUpper>()), upper);
    block = M;
    dense::symmetric_update_lower(W, Z, block);
    const MatrixXd expected = M + W * Z.transpose() + Z * W.transpose();
    EXPECT_TRUE(test::agree(lower(block), lower(expected), kDenseTolerance));
    EXPECT_EQ(MatrixXd(block.template triangularView<Eigen::StrictlyUpper>()), upper);
  });
}

TEST(Dense, ProductsAreThoseOfEigen) {
  for_each_size([](const MatrixXd& M, auto block, test::Random& random) {
    const Eigen::Index n = M.rows();
    const MatrixXd A = random_dense(random, 4, n);
    const MatrixXd B = random_dense(random, n, 5);
    EXPECT_TRUE(test::agree(dense::product(A, B), A * B, kDenseTolerance));
    const MatrixXd C = random_dense(random, n, 4);
    dense::add_product(-0.5, C, A, block);
    EXPECT_TRUE(test::agree(block, M - 0.5 * C * A, kDenseTolerance));
  });
}

TEST(Dense, SymmetricOperationsReadTheLowerTriangleAlone) {
  for_each_size([](const MatrixXd& M, auto block, test::Random& random) {
    const Eigen::Index n = M.rows();
    block.template triangularView<Eigen::StrictlyUpper>().setConstant(kUntouched);
    const Eigen::VectorXd x = random.normal_vector(n);
    Eigen::VectorXd y = random.normal_vector(n);
    const Eigen::VectorXd expected = y + M * x;
    dense::add_symmetric_product(block, x, y);
    EXPECT_TRUE(test::agree(y, expected, kDenseTolerance));
    for (const Eigen::Index first : {Eigen::Index{0}, n / 3, n / 2}) {
      const Eigen::Index count = (n - first + 1) / 2;
      EXPECT_EQ(dense::symmetric_rows(block, first, count), M.middleRows(first, count));
    }
    EXPECT_EQ(dense::symmetric_rows(block, 0, n), M);
  });
}

TEST(Dense, SymmetricProductIsAddedToTheLowerTriangle) {
  for_each_size([](const MatrixXd& M, auto block, test::Random& random) {
    const MatrixXd W = random_dense(random, M.rows(), 4);
    const MatrixXd C = test::random_covariance(random, 4, 1);
    dense::add_product_lower(W * C, W.transpose(), block);
    EXPECT_TRUE(test::agree(lower(block), lower(M + W * C * W.transpose()), kDenseTolerance));
  });
}

TEST(Dense, TheProductWithASymmetricMatrixReadsTheLowerTriangle) {
  for_each_size([](const MatrixXd& M, auto block, test::Random& random) {
    block.template triangularView<Eigen::StrictlyUpper>().setConstant(kUntouched);
    const MatrixXd B = random_dense(random, M.rows(), 3);
    const MatrixXd expected = M.selfadjointView<Lower>() * B;
    EXPECT_TRUE(test::agree(dense::symmetric_product(block, B), expected, kDenseTolerance));
  });
}

TEST(Dense, MirrorCopiesTheLowerTriangleUp) {
  for_each_size([](const MatrixXd& M, auto block, test::Random&) {
    block.template triangularView<Eigen::StrictlyUpper>().setConstant(kUntouched);
    dense::mirror_lower(block);
    const MatrixXd expected = M.selfadjointView<Lower>();
    EXPECT_EQ(MatrixXd(block), expected);
  });
}

TEST(Dense, ASymmetricProductIsAddedToTheLowerTriangleAlsoBeyondOnePanel) {
  test::Random random(31);
  const Eigen::Index n = 150;
  const Eigen::MatrixXd A = random.normal_vector(n * 7).reshaped(n, 7);
  const Eigen::MatrixXd B = A.transpose();
  const Eigen::MatrixXd before = random.normal_vector(n * n).reshaped(n, n);
  Eigen::MatrixXd P = before;
  dense::add_product_lower(A, B, P);
  const Eigen::MatrixXd error = P - (before + A * B);
  EXPECT_LT(error.triangularView<Eigen::Lower>().toDenseMatrix().norm(), 1e-11);
}

// Estimators may work in several threads of a program.
TEST(Dense, ConcurrentCallsDoNotDisturbEachOther) {
  test::Random random(9);
  const MatrixXd A = random_dense(random, 120, 90), B = random_dense(random, 90, 110);
  const MatrixXd S = A.transpose() * A + MatrixXd::Identity(90, 90);
  const auto work = [&] {
    MatrixXd L = S, X = B, P = S;
    EXPECT_TRUE(dense::cholesky(L));
    dense::solve_lower(L, X);
    dense::downdate_lower(X, P);
    return MatrixXd(dense::product(A, X) + dense::product(A, lower(P)) * MatrixXd::Ones(90, 110));
  };
  const MatrixXd expected = work();
  std::array<int, 4> wrong{};
  std::vector<std::thread> threads;
  for (int& count : wrong) {
    threads.emplace_back([&] {
      for (int i = 0; i < 300; ++i) count += work() == expected ? 0 : 1;
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, (std::array<int, 4>{}));
}

TEST(Dense, AProcessorGetsTheKernelsThatItSupports) {
  using dense::better_kernels;
  EXPECT_EQ(better_kernels("Prescott", false, false), "");
  EXPECT_EQ(better_kernels("Prescott", true, false), "Haswell");
  EXPECT_EQ(better_kernels("Prescott", true, true), "SkylakeX");
  EXPECT_EQ(better_kernels("Zen", true, false), "");
  EXPECT_EQ(better_kernels("Zen", true, true), "SkylakeX");
  EXPECT_EQ(better_kernels("Haswell", true, true), "SkylakeX");
  EXPECT_EQ(better_kernels("SkylakeX", true, true), "");
  EXPECT_EQ(better_kernels("Cooperlake", true, true), "");
}

#if defined(__x86_64__)
TEST(Dense, AProcessorThatOpenBlasDoesNotKnowStillGetsItsKernels) {
  dense::prepare();
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) {
    EXPECT_NE(dense::kernels(), "Prescott");
  }
  const MatrixXd A = MatrixXd::Random(70, 50);
  EXPECT_TRUE(test::agree(dense::product(A.transpose(), A), A.transpose() * A, kDenseTolerance));
}
#endif

}  // namespace
}  // namespace chasles
