#include <algorithm>
#include <limits>

#include <chasles/filter/compression.hpp>
#include <chasles/filter/whitening.hpp>

namespace chasles {
namespace {

using Eigen::VectorXd;

// visit(measurement, first row of H, row of its landmark).
template <class Visitor>
void for_each_landmark(Measurements measurements, const State& x, const Visitor& visit) {
  Eigen::Index at = 0;
  for (const Measurement* z : measurements) {
    if (z->landmark >= 0) visit(*z, at, x.landmarks[static_cast<std::size_t>(z->landmark)].row);
    at += z->residual.size();
  }
}

// visit(part of a measurement, first row of H).
template <class Visitor>
void for_each_clone(Measurements measurements, const Visitor& visit) {
  Eigen::Index at = 0;
  for (const Measurement* z : measurements) {
    for (const Measurement::OfClone& clone : z->clones) visit(clone, at);
    at += z->residual.size();
  }
}

// Collects the rows of the clones in the scratch. Returns their number if at least half of the
// blocks of a dense matrix exist: fast products then outweigh the cost of gathering. Otherwise
// zero.
Eigen::Index dense_clones(Measurements measurements, WhiteningScratch& scratch) {
  std::vector<int>& rows = scratch.clone_rows;
  rows.clear();
  std::size_t parts = 0;
  for (const Measurement* z : measurements) {
    parts += z->clones.size();
    for (const Measurement::OfClone& clone : z->clones) {
      const auto place = std::lower_bound(rows.begin(), rows.end(), clone.row);
      if (place == rows.end() || *place != clone.row) rows.insert(place, clone.row);
    }
  }
  const bool sparse = 2 * parts < rows.size() * measurements.size();
  return sparse ? 0 : static_cast<Eigen::Index>(rows.size());
}

// The columns of the core that any of the measurements depends on.
Jacobian::Columns columns_of_core(Measurements measurements) {
  int first = std::numeric_limits<int>::max(), end = 0;
  for (const Measurement* z : measurements) {
    const auto width = static_cast<int>(z->d_core.cols());
    if (width == 0) continue;
    first = std::min(first, z->core_column);
    end = std::max(end, z->core_column + width);
  }
  return end == 0 ? Jacobian::Columns{} : Jacobian::Columns{.first = first, .width = end - first};
}

// Number of rows factorised together. With fewer, BLAS's kernels would not be filled. With more,
// slow triangular solutions would replace fast products.
constexpr Eigen::Index kLeafRows = 32;

// From P H^T, Z H^T and r to W, kept and w, recursively by halves: the information of the first
// half is removed from the second. False if S is not positive definite. Kernels of BLAS add in an
// order that depends on the number of rows, so W is by itself: what is kept of the past does not
// change it.
bool whiten(Measurements z, const State& x, dense::Block W, dense::Block kept,
            Eigen::Ref<VectorXd> w, WhiteningScratch& scratch) {
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
    dense::solve_lower_from_right(S, kept);
    dense::solve_lower(S, w);
    return true;
  }
  const Measurements first = z.first(z.size() / 2);
  const Measurements second = z.subspan(first.size());
  const Eigen::Index k = rows_of(first);
  const Eigen::Index rest = w.size() - k;
  if (!whiten(first, x, W.leftCols(k), kept.leftCols(k), w.head(k), scratch)) return false;
  auto HW = scratch.HW.take(rest, k);
  Jacobian(second, x, scratch).times(W.leftCols(k), HW);
  dense::subtract_outer(W.leftCols(k), HW, W.rightCols(rest));
  dense::subtract_outer(kept.leftCols(k), HW, kept.rightCols(rest));
  w.tail(rest).noalias() -= HW * w.head(k);
  return whiten(second, x, W.rightCols(rest), kept.rightCols(rest), w.tail(rest), scratch);
}

}  // namespace

Eigen::Index rows_of(Measurements z) {
  Eigen::Index m = 0;
  for (const Measurement* one : z) m += one->residual.size();
  return m;
}

Jacobian::Jacobian(Measurements measurements, const State& x, WhiteningScratch& scratch)
    : measurements_(measurements),
      state_(x),
      scratch_(scratch),
      used_(columns_of_core(measurements)),
      core_(scratch.core.take(rows_of(measurements), used_.width)),
      clones_(scratch.clones.take(core_.rows(), 6 * dense_clones(measurements, scratch))) {
  core_.setZero();
  clones_.setZero();
  Eigen::Index at = 0;
  for (const Measurement* z : measurements_) {
    const Eigen::Index k = z->residual.size(), width = z->d_core.cols();
    if (width > 0) core_.block(at, z->core_column - used_.first, k, width) = z->d_core;
    at += k;
  }
  if (clones_.cols() == 0) return;
  for_each_clone(measurements_, [&](const Measurement::OfClone& clone, Eigen::Index row) {
    const auto& rows = scratch_.clone_rows;
    const auto six = std::lower_bound(rows.begin(), rows.end(), clone.row) - rows.begin();
    clones_.block(row, 6 * six, clone.d.rows(), 6) += clone.d;
  });
}

void Jacobian::times(const dense::ConstBlock& M, dense::Block result) const {
  dense::multiply(core_, M.middleRows(used_.first, used_.width), result);
  for_each_landmark(
      measurements_, state_, [&](const Measurement& z, Eigen::Index at, Eigen::Index row) {
        result.middleRows(at, z.residual.size()) += z.d_landmark.lazyProduct(M.middleRows<3>(row));
      });
  if (clones_.cols() == 0) {
    for_each_clone(measurements_, [&](const Measurement::OfClone& clone, Eigen::Index at) {
      result.middleRows(at, clone.d.rows()) += clone.d.lazyProduct(M.middleRows<6>(clone.row));
    });
    return;
  }
  auto gathered = scratch_.gathered.take(clones_.cols(), M.cols());
  Eigen::Index six = 0;
  for (const int row : scratch_.clone_rows)
    gathered.middleRows<6>(6 * six++) = M.middleRows<6>(row);
  dense::add_product(1, clones_, gathered, result);
}

void Jacobian::times_transpose(const dense::ConstBlock& P, dense::Block result) const {
  auto transposed = scratch_.transposed.take(core_.cols(), core_.rows());
  transposed = core_.transpose();
  dense::multiply(P.middleCols(used_.first, used_.width), transposed, result);
  for_each_landmark(measurements_, state_,
                    [&](const Measurement& z, Eigen::Index at, Eigen::Index row) {
                      for (Eigen::Index k = 0; k < z.residual.size(); ++k) {
                        const Eigen::Vector3d d = z.d_landmark.row(k);
                        result.col(at + k) +=
                            d.x() * P.col(row) + d.y() * P.col(row + 1) + d.z() * P.col(row + 2);
                      }
                    });
  if (clones_.cols() == 0) {
    for_each_clone(measurements_, [&](const Measurement::OfClone& clone, Eigen::Index at) {
      result.middleCols(at, clone.d.rows()) +=
          P.middleCols<6>(clone.row).lazyProduct(clone.d.transpose());
    });
    return;
  }
  auto gathered = scratch_.gathered.take(P.rows(), clones_.cols());
  Eigen::Index six = 0;
  for (const int row : scratch_.clone_rows)
    gathered.middleCols<6>(6 * six++) = P.middleCols<6>(row);
  auto clones_transposed = scratch_.transposed.take(clones_.cols(), clones_.rows());
  clones_transposed = clones_.transpose();
  dense::add_product(1, gathered, clones_transposed, result);
}

bool Jacobian::is_of_clones() const {
  return clones_.cols() > 0 && std::ranges::all_of(measurements_, [](const Measurement* z) {
           return z->landmark < 0 && z->d_core.cols() == 0;
         });
}

void Jacobian::square_of_clones(const Covariance& covariance, dense::Block result) const {
  const auto P = covariance.all();
  const std::vector<int>& rows = scratch_.clone_rows;
  auto gathered = scratch_.gathered.take(clones_.cols(), clones_.cols());
  for (std::size_t j = 0; j < rows.size(); ++j) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      gathered.block<6, 6>(6 * static_cast<Eigen::Index>(i), 6 * static_cast<Eigen::Index>(j)) =
          P.block<6, 6>(rows[i], rows[j]);
    }
  }
  auto transposed = scratch_.transposed.take(clones_.cols(), clones_.rows());
  transposed = clones_.transpose();
  auto PHt = scratch_.W.take(clones_.cols(), clones_.rows());
  dense::multiply(gathered, transposed, PHt);
  dense::multiply(clones_, PHt, result);
}

double normalised_square(Measurements measurements, const Covariance& covariance, const State& x,
                         WhiteningScratch& scratch) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const Jacobian H(measurements, x, scratch);
  if (!H.is_of_clones()) {
    const auto z =
        whiten(measurements, covariance, Eigen::MatrixXd(0, covariance.size()), x, scratch);
    return z ? z->nis : kInfinite;
  }
  const Eigen::Index m = rows_of(measurements);
  auto S = scratch.S.take(m, m);
  H.square_of_clones(covariance, S);
  auto w = scratch.w.take<VectorXd>(m);
  Eigen::Index at = 0;
  for (const Measurement* one : measurements) {
    const Eigen::Index k = one->residual.size();
    S.block(at, at, k, k) += one->noise;
    w.segment(at, k) = one->residual;
    at += k;
  }
  if (!dense::cholesky(S)) return kInfinite;
  dense::solve_lower(S, w);
  return w.squaredNorm();
}

std::optional<Whitened> whiten(Measurements measurements, const Covariance& covariance,
                               const dense::ConstBlock& Z, const State& x,
                               WhiteningScratch& scratch) {
  if (can_be_compressed(measurements, scratch)) {
    return whiten_compressed(measurements, covariance, Z, scratch);
  }
  const Eigen::Index m = rows_of(measurements);
  Whitened result{.W = scratch.W.take(covariance.size(), m),
                  .kept = scratch.kept.take(Z.rows(), m),
                  .w = scratch.w.take<VectorXd>(m)};
  const Jacobian H(measurements, x, scratch);
  H.times_transpose(covariance.all(), result.W);
  if (Z.rows() > 0) H.times_transpose(Z, result.kept);
  Eigen::Index at = 0;
  for (const Measurement* one : measurements) {
    result.w.segment(at, one->residual.size()) = one->residual;
    at += one->residual.size();
  }
  if (!whiten(measurements, x, result.W, result.kept, result.w, scratch)) return std::nullopt;
  result.nis = result.w.squaredNorm();
  return result;
}

}  // namespace chasles
