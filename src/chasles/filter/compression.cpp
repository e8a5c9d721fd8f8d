#include <algorithm>

#include <Eigen/Cholesky>

#include <chasles/filter/compression.hpp>

namespace chasles {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
template <class Matrix>
using Map = Eigen::Map<Matrix, Eigen::AlignedMax>;

bool is_of_clones(const Measurement& z) { return z.landmark < 0 && z.d_core.cols() == 0; }

// The first rows of the blocks of six that the measurements depend on, each once, rising.
void find_rows(Measurements measurements, std::vector<int>& rows) {
  rows.clear();
  for (const Measurement* z : measurements) {
    for (const Measurement::OfClone& clone : z->clones) {
      const auto place = std::lower_bound(rows.begin(), rows.end(), clone.row);
      if (place == rows.end() || *place != clone.row) rows.insert(place, clone.row);
    }
  }
}

// H and r <- R^-1/2 H and R^-1/2 r; false where a noise is not positive definite.
bool stack(Measurements measurements, const std::vector<int>& rows, Map<MatrixXd> H,
           Map<VectorXd> r) {
  H.setZero();
  Index at = 0;
  for (const Measurement* z : measurements) {
    const Index k = z->residual.size();
    const auto noise = z->noise.llt();
    if (noise.info() != Eigen::Success) return false;
    r.segment(at, k) = noise.matrixL().solve(z->residual);
    for (const Measurement::OfClone& clone : z->clones) {
      const auto six = std::lower_bound(rows.begin(), rows.end(), clone.row) - rows.begin();
      H.block(at, 6 * six, k, 6) += noise.matrixL().solve(clone.d);
    }
    at += k;
  }
  return true;
}

struct Compressed {
  Map<MatrixXd> Lt;  // rank x c
  Map<VectorXd> z;
  double outside;  // squared norm of the part of r outside the range of H
};

// L and z of the header; none if a number is not finite.
std::optional<Compressed> compress(const Map<MatrixXd>& H, const Map<VectorXd>& r,
                                   WhiteningScratch& scratch) {
  const Index c = H.cols();
  auto information = scratch.S.take(c, c);
  dense::square_lower(H, information);
  auto b = scratch.information.take<VectorXd>(c);
  b.noalias() = H.transpose() * r;
  if (!b.allFinite()) return std::nullopt;
  const Index rank = dense::pivoted_cholesky(information, scratch.order, scratch.HW);
  Compressed result{.Lt = scratch.transposed.take(rank, c),
                    .z = scratch.w.take<VectorXd>(rank),
                    .outside = r.squaredNorm()};
  result.Lt.setZero();
  for (Index k = 0; k < c; ++k) {
    const Index error = scratch.order[static_cast<std::size_t>(k)];
    const Index known = std::min(k + 1, rank);
    result.Lt.col(error).head(known) = information.row(k).head(known).transpose();
    if (k < rank) result.z[k] = b[error];
  }
  dense::solve_lower(information.topLeftCorner(rank, rank), result.z);
  result.outside -= result.z.squaredNorm();
  return result;
}

// P L for a P with a column for every error of the state.
void times_factor(const dense::ConstBlock& P, const Map<MatrixXd>& Lt, WhiteningScratch& scratch,
                  dense::Block result) {
  auto of_clones = scratch.gathered.take(P.rows(), Lt.cols());
  Index six = 0;
  for (const int row : scratch.clone_rows)
    of_clones.middleCols<6>(6 * six++) = P.middleCols<6>(row);
  auto L = scratch.HW.take(Lt.cols(), Lt.rows());
  L = Lt.transpose();
  dense::multiply(of_clones, L, result);
}

}  // namespace

bool can_be_compressed(Measurements measurements, WhiteningScratch& scratch) {
  const bool of_clones =
      std::ranges::all_of(measurements, [](const Measurement* z) { return is_of_clones(*z); });
  if (!of_clones) return false;
  find_rows(measurements, scratch.clone_rows);
  return rows_of(measurements) > 6 * static_cast<Index>(scratch.clone_rows.size());
}

std::optional<Whitened> whiten_compressed(Measurements measurements, const Covariance& covariance,
                                          const dense::ConstBlock& Z, WhiteningScratch& scratch) {
  const std::vector<int>& rows = scratch.clone_rows;
  find_rows(measurements, scratch.clone_rows);
  const Index m = rows_of(measurements), c = 6 * static_cast<Index>(rows.size());
  auto H = scratch.clones.take(m, c);
  auto r = scratch.residual.take<VectorXd>(m);
  if (!stack(measurements, rows, H, r)) return std::nullopt;
  const auto compressed = compress(H, r, scratch);
  if (!compressed) return std::nullopt;
  const auto& [Lt, z, outside] = *compressed;
  const Index rank = Lt.rows();

  Whitened result{.W = scratch.W.take(covariance.size(), rank),
                  .kept = scratch.kept.take(Z.rows(), rank),
                  .w = z};
  times_factor(covariance.all(), Lt, scratch, result.W);
  if (Z.rows() > 0) times_factor(Z, Lt, scratch, result.kept);
  auto PL = scratch.gathered.take(c, rank);
  Index six = 0;
  for (const int row : rows) PL.middleRows<6>(6 * six++) = result.W.middleRows<6>(row);
  auto S = scratch.S.take(rank, rank);
  dense::multiply(Lt, PL, S);
  S.diagonal().array() += 1;
  if (!dense::cholesky(S)) return std::nullopt;
  dense::solve_lower_from_right(S, result.W);
  dense::solve_lower_from_right(S, result.kept);
  dense::solve_lower(S, result.w);
  result.nis = outside + result.w.squaredNorm();
  return result;
}

}  // namespace chasles
