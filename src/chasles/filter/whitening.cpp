#include <chasles/filter/whitening.hpp>

namespace chasles {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

// Rows that are factorised together: with fewer, BLAS's kernels would not be filled; with more, the
// slow triangular solution would take what the fast products can do.
constexpr Eigen::Index kLeafRows = 32;

// From P H^T and r to W and w, by halves: what the first half has told is taken out of the second.
// False where S is not positive definite.
bool whiten(Measurements z, const State& x, Eigen::Ref<MatrixXd, 0, Eigen::OuterStride<>> W,
            Eigen::Ref<VectorXd> w) {
  if (z.size() == 1 || w.size() <= kLeafRows) {
    MatrixXd S = Jacobian(z, x).times(W);
    Eigen::Index at = 0;
    for (const Measurement* one : z) {
      const Eigen::Index k = one->residual.size();
      S.block(at, at, k, k) += one->noise;
      at += k;
    }
    if (!dense::cholesky(S)) return false;
    dense::solve_lower_from_right(S, W);
    dense::solve_lower(S, w);
    return true;
  }
  const Measurements first = z.first(z.size() / 2);
  const Measurements second = z.subspan(first.size());
  const Eigen::Index k = rows_of(first);
  const Eigen::Index rest = w.size() - k;
  if (!whiten(first, x, W.leftCols(k), w.head(k))) return false;
  const MatrixXd HW = Jacobian(second, x).times(W.leftCols(k));
  dense::add_product(-1, W.leftCols(k), HW.transpose().eval(), W.rightCols(rest));
  w.tail(rest).noalias() -= HW * w.head(k);
  return whiten(second, x, W.rightCols(rest), w.tail(rest));
}

}  // namespace

Eigen::Index rows_of(Measurements z) {
  Eigen::Index m = 0;
  for (const Measurement* one : z) m += one->residual.size();
  return m;
}

std::optional<Whitened> whiten(Measurements measurements, const Covariance& covariance,
                               const State& x) {
  Whitened result{Jacobian(measurements, x).times_transpose(covariance),
                  VectorXd(rows_of(measurements))};
  Eigen::Index at = 0;
  for (const Measurement* one : measurements) {
    result.w.segment(at, one->residual.size()) = one->residual;
    at += one->residual.size();
  }
  if (!whiten(measurements, x, result.W, result.w)) return std::nullopt;
  return result;
}

}  // namespace chasles
