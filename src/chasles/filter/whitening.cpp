#include <chasles/filter/whitening.hpp>

namespace chasles {
namespace {

using Eigen::VectorXd;

// Rows that are factorised together: with fewer, BLAS's kernels would not be filled; with more, the
// slow triangular solution would take what the fast products can do.
constexpr Eigen::Index kLeafRows = 32;

// From P H^T and r to W and w, by halves: what the first half has told is taken out of the second.
// False where S is not positive definite.
bool whiten(Measurements z, const State& x, dense::Block W, Eigen::Ref<VectorXd> w,
            WhiteningScratch& scratch) {
  if (z.size() == 1 || w.size() <= kLeafRows) {
    auto S = scratch.S.take(w.size(), w.size());
    Jacobian(z, x, scratch).times(W, S);
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
  if (!whiten(first, x, W.leftCols(k), w.head(k), scratch)) return false;
  auto HW = scratch.HW.take(rest, k);
  Jacobian(second, x, scratch).times(W.leftCols(k), HW);
  auto HW_transposed = scratch.HW_transposed.take(k, rest);
  HW_transposed = HW.transpose();
  dense::add_product(-1, W.leftCols(k), HW_transposed, W.rightCols(rest));
  w.tail(rest).noalias() -= HW * w.head(k);
  return whiten(second, x, W.rightCols(rest), w.tail(rest), scratch);
}

}  // namespace

Eigen::Index rows_of(Measurements z) {
  Eigen::Index m = 0;
  for (const Measurement* one : z) m += one->residual.size();
  return m;
}

std::optional<Whitened> whiten(Measurements measurements, const Covariance& covariance,
                               const State& x, WhiteningScratch& scratch) {
  const Eigen::Index m = rows_of(measurements);
  Whitened result{scratch.W.take(covariance.size(), m), scratch.w.take<VectorXd>(m)};
  Jacobian(measurements, x, scratch).times_transpose(covariance, result.W);
  Eigen::Index at = 0;
  for (const Measurement* one : measurements) {
    result.w.segment(at, one->residual.size()) = one->residual;
    at += one->residual.size();
  }
  if (!whiten(measurements, x, result.W, result.w, scratch)) return std::nullopt;
  return result;
}

}  // namespace chasles
