#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include <chasles/base/error.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/loop/joint_covariance.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;

// B with B B^T = P of one point, and its inverse where P is regular.
struct Root {
  Matrix3d B, inverse;
};

Root root(const Matrix3d& P) {
  constexpr double kSingular = 1e-10;
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(P);
  const Eigen::Vector3d values = solver.eigenvalues().cwiseMax(0);
  Root result{Matrix3d::Zero(), Matrix3d::Zero()};
  for (int i = 0; i < 3; ++i) {
    if (!(values(i) > kSingular * values(2))) continue;
    const Eigen::Vector3d axis = solver.eigenvectors().col(i);
    result.B.col(i) = std::sqrt(values(i)) * axis;
    result.inverse.row(i) = axis.transpose() / std::sqrt(values(i));
  }
  return result;
}

MatrixXd orthonormal(const MatrixXd& A) {
  const Eigen::HouseholderQR<MatrixXd> qr(A);
  return qr.householderQ() * MatrixXd::Identity(A.rows(), A.cols());
}

// The largest eigenvalues of a positive semidefinite K, with vectors of that square length, from
// its products with random vectors (Halko, Martinsson & Tropp, SIAM Review 2011, one power
// iteration).
MatrixXd largest_directions(const MatrixXd& K, int most) {
  constexpr int kMore = 8;
  const Index columns = std::min<Index>(K.rows(), most + kMore);
  std::mt19937_64 random(1);  // NOLINT(cert-msc51-cpp): same bytes every time
  MatrixXd A(K.rows(), columns);
  for (Index j = 0; j < columns; ++j) {
    for (Index i = 0; i < K.rows(); ++i) A(i, j) = (random() & 1U) != 0 ? 1 : -1;
  }
  const MatrixXd Q = orthonormal(dense::product(K, orthonormal(dense::product(K, A))));
  const MatrixXd KQ = dense::product(K, Q), Q_transposed = Q.transpose();
  const MatrixXd small = dense::product(Q_transposed, KQ);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver((small + small.transpose()) / 2);
  const Index rank = std::min<Index>(most, columns);
  MatrixXd U(K.rows(), rank);
  for (Index i = 0; i < rank; ++i) {  // the largest first
    const Index from = columns - 1 - i;
    const double value = std::max(solver.eigenvalues()(from), 0.0);
    U.col(i) = std::sqrt(value) * (Q * solver.eigenvectors().col(from));
  }
  return U;
}

// Every point in units of its own sigmas.
class Scaled {
 public:
  explicit Scaled(const std::vector<Matrix3d>& blocks) {
    for (const Matrix3d& block : blocks) roots_.push_back(root(block));
  }
  MatrixXd rows(const MatrixXd& A) const { return times(A, true); }
  MatrixXd back(const MatrixXd& A) const { return times(A, false); }

 private:
  MatrixXd times(const MatrixXd& A, bool inverse) const {
    MatrixXd result(A.rows(), A.cols());
    for (std::size_t i = 0; i < roots_.size(); ++i) {
      const Index at = 3 * static_cast<Index>(i);
      result.middleRows<3>(at) = (inverse ? roots_[i].inverse : roots_[i].B) * A.middleRows<3>(at);
    }
    return result;
  }

  std::vector<Root> roots_;
};

// The smallest number of columns of U for which K - U U^T is small enough beside its diagonal
// blocks. U has orthogonal columns, the longest first; K the given diagonal blocks and sum of
// squares. The difference of squares is accurate to some 1e-8 of their root, so an error of 0 means
// all columns.
Index enough(const MatrixXd& U, std::vector<Matrix3d> blocks, double squares,
             const JointCovariance::Limits& limits) {
  const Index most = std::min<Index>(U.cols(), limits.rank);
  const double numbers = static_cast<double>(U.rows()) * static_cast<double>(U.rows());
  for (Index rank = 0;; ++rank) {
    double rest = squares;
    for (const Matrix3d& block : blocks) rest -= block.squaredNorm();
    const bool small = limits.error > 0 && rest <= limits.error * limits.error * numbers;
    if (rank == most || small) return rank;
    const double value = U.col(rank).squaredNorm();
    squares -= value * value;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      const Eigen::Vector3d u = U.col(rank).segment<3>(3 * static_cast<Index>(i));
      blocks[i] -= u * u.transpose();
    }
  }
}

std::vector<Matrix3d> diagonal_blocks(const MatrixXd& P) {
  std::vector<Matrix3d> blocks;
  for (Index i = 0; i < P.rows(); i += 3) blocks.emplace_back(P.block<3, 3>(i, i));
  return blocks;
}

Matrix3d positive(const Matrix3d& P) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver((P + P.transpose()) / 2);
  const Matrix3d V = solver.eigenvectors();
  return V * solver.eigenvalues().cwiseMax(0).asDiagonal() * V.transpose();
}

// With these shared directions; what is left of each point's covariance is its own.
JointCovariance with_shared(const std::vector<Matrix3d>& blocks, MatrixXd U) {
  std::vector<Matrix3d> own;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const auto rows = U.middleRows<3>(3 * static_cast<Index>(i));
    own.push_back(positive(blocks[i] - rows * rows.transpose()));
  }
  return {std::move(own), std::move(U)};
}

}  // namespace

JointCovariance::JointCovariance(std::vector<Matrix3d> own, MatrixXd shared)
    : own_(std::move(own)), shared_(std::move(shared)) {
  if (shared_.rows() != 3 * static_cast<Index>(own_.size())) {
    throw UsageError("the joint covariance of points has three rows for each of them");
  }
}

JointCovariance JointCovariance::of_matrix(const MatrixXd& P, const Limits& limits) {
  if (P.rows() != P.cols() || P.rows() % 3 != 0) {
    throw UsageError("the joint covariance of points has three rows for each of them");
  }
  if (P.rows() == 0) return {};
  const std::vector<Matrix3d> blocks = diagonal_blocks(P);
  const Scaled scaled(blocks);
  const MatrixXd K = scaled.rows(scaled.rows(P).transpose());
  const MatrixXd U = largest_directions(K, limits.rank);
  const Index rank = enough(U, diagonal_blocks(K), K.squaredNorm(), limits);
  return with_shared(blocks, scaled.back(U.leftCols(rank)));
}

JointCovariance JointCovariance::reduced(const Limits& limits) const {
  if (rank() == 0) return *this;
  std::vector<Matrix3d> blocks;
  for (int i = 0; i < points(); ++i) blocks.push_back(of(i));
  const Scaled scaled(blocks);
  const MatrixXd U = scaled.rows(shared_), U_transposed = U.transpose();
  // U U^T and U^T U have the same eigenvalues.
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(dense::product(U_transposed, U));
  const MatrixXd turned = dense::product(U, solver.eigenvectors().rowwise().reverse());
  std::vector<Matrix3d> of_shared;
  for (Index i = 0; i < U.rows(); i += 3) {
    of_shared.emplace_back(U.middleRows<3>(i) * U.middleRows<3>(i).transpose());
  }
  const Index rank =
      enough(turned, std::move(of_shared), solver.eigenvalues().squaredNorm(), limits);
  return with_shared(blocks, scaled.back(turned.leftCols(rank)));
}

Matrix3d JointCovariance::of(int point) const {
  const auto U = shared_.middleRows<3>(3 * static_cast<Index>(point));
  return own_[static_cast<std::size_t>(point)] + U * U.transpose();
}

MatrixXd JointCovariance::of(std::span<const int> points) const {
  const auto n = static_cast<Index>(points.size());
  MatrixXd U(3 * n, rank());
  for (Index i = 0; i < n; ++i) {
    const Index from = 3 * static_cast<Index>(points[static_cast<std::size_t>(i)]);
    U.middleRows<3>(3 * i) = shared_.middleRows<3>(from);
  }
  const MatrixXd U_transposed = U.transpose();
  MatrixXd P = dense::product(U, U_transposed);
  for (Index i = 0; i < n; ++i) {
    P.block<3, 3>(3 * i, 3 * i) +=
        own_[static_cast<std::size_t>(points[static_cast<std::size_t>(i)])];
  }
  return P;
}

// The points' covariance without what x explains of it has shared directions of its own.
SharedPart shared_part(const MatrixXd& P_x, const MatrixXd& P_points_x, const MatrixXd& P_points) {
  constexpr double kExact = 1e-9;  // sigma of a direction of x that is known exactly
  const Index r = P_x.rows(), m = P_points.rows();
  SharedPart part;
  MatrixXd by_y(m, r);
  if (r > 0) {
    const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(P_x);
    const Eigen::VectorXd sigmas = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
    const Eigen::VectorXd inverse =
        sigmas.unaryExpr([](double s) { return s > kExact ? 1 / s : 0.0; });
    part.root = solver.eigenvectors() * sigmas.asDiagonal();
    by_y = dense::product(P_points_x, solver.eigenvectors() * inverse.asDiagonal());
  } else {
    part.root.resize(0, 0);
  }
  const MatrixXd transposed = by_y.transpose();
  const JointCovariance rest =
      JointCovariance::of_matrix(P_points - dense::product(by_y, transposed), {});
  MatrixXd shared(m, r + rest.rank());
  shared << by_y, rest.shared();
  part.others = JointCovariance(rest.own(), std::move(shared));
  return part;
}

}  // namespace chasles
