#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include <chasles/filter/covariance.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/measurement.hpp>
#include <chasles/filter/scratch.hpp>

/// The algebra of an update, on the sparsity of its measurements (docs/filter.md, section 3).
namespace chasles {

using Measurements = std::span<const Measurement* const>;

/// Rows of all residuals together.
Eigen::Index rows_of(Measurements z);

/// The Jacobian H of some measurements, m x n: dense in the core, three columns for a landmark, six
/// for a clone. Measurements, state and scratch must outlive it, and two do not share a scratch.
class Jacobian {
 public:
  Jacobian(Measurements measurements, const State& x, WhiteningScratch& scratch)
      : measurements_(measurements),
        state_(x),
        scratch_(scratch),
        core_(scratch.core.take(rows_of(measurements), x.core_size())) {
    core_.setZero();
    Eigen::Index at = 0;
    for (const Measurement* z : measurements_) {
      core_.block(at, z->core_column, z->residual.size(), z->d_core.cols()) = z->d_core;
      at += z->residual.size();
    }
  }

  /// result <- H M for an M with a row for every error.
  void times(const dense::ConstBlock& M, dense::Block result) const {
    dense::multiply(core_, M.topRows(core_.cols()), result);
    for_each_landmark([&](const Measurement& z, Eigen::Index at, Eigen::Index row) {
      result.middleRows(at, z.residual.size()) += z.d_landmark.lazyProduct(M.middleRows<3>(row));
    });
    for_each_clone([&](const Measurement::OfClone& clone, Eigen::Index at) {
      result.middleRows(at, clone.d.rows()) += clone.d.lazyProduct(M.middleRows<6>(clone.row));
    });
  }

  /// result <- P H^T, n x m, for a symmetric P, whose columns are contiguous.
  void times_transpose(const Covariance& covariance, dense::Block result) const {
    const auto P = covariance.all();
    auto transposed = scratch_.core_transposed.take(core_.cols(), core_.rows());
    transposed = core_.transpose();
    dense::multiply(P.leftCols(core_.cols()), transposed, result);
    for_each_landmark([&](const Measurement& z, Eigen::Index at, Eigen::Index row) {
      result.middleCols(at, z.residual.size()) +=
          P.middleCols<3>(row).lazyProduct(z.d_landmark.transpose());
    });
    for_each_clone([&](const Measurement::OfClone& clone, Eigen::Index at) {
      result.middleCols(at, clone.d.rows()) +=
          P.middleCols<6>(clone.row).lazyProduct(clone.d.transpose());
    });
  }

 private:
  template <class Visitor>
  void for_each_landmark(const Visitor& visit) const {
    Eigen::Index at = 0;
    for (const Measurement* z : measurements_) {
      if (z->landmark >= 0) {
        visit(*z, at, state_.landmarks[static_cast<std::size_t>(z->landmark)].row);
      }
      at += z->residual.size();
    }
  }

  template <class Visitor>
  void for_each_clone(const Visitor& visit) const {
    Eigen::Index at = 0;
    for (const Measurement* z : measurements_) {
      for (const Measurement::OfClone& clone : z->clones) visit(clone, at);
      at += z->residual.size();
    }
  }

  Measurements measurements_;
  const State& state_;
  WhiteningScratch& scratch_;
  Eigen::Map<Eigen::MatrixXd, Eigen::AlignedMax> core_;
};

/// With S = H P H^T + R = L L^T: W = P H^T L^-T (n x m) and w = L^-1 r, so that the correction of
/// an update is W w, its NIS w^T w, and the covariance loses W W^T. Both stand in the scratch.
struct Whitened {
  Eigen::Map<Eigen::MatrixXd, Eigen::AlignedMax> W;
  Eigen::Map<Eigen::VectorXd, Eigen::AlignedMax> w;
};

/// None where S is not positive definite.
std::optional<Whitened> whiten(Measurements measurements, const Covariance& covariance,
                               const State& x, WhiteningScratch& scratch);

}  // namespace chasles
