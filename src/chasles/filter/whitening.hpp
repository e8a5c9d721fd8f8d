#pragma once

#include <optional>
#include <span>

#include <Eigen/Core>

#include <chasles/filter/covariance.hpp>
#include <chasles/filter/dense.hpp>
#include <chasles/filter/measurement.hpp>
#include <chasles/filter/scratch.hpp>

/// The algebra of an update, using the sparsity of its measurements (docs/filter.md, section 3).
namespace chasles {

using Measurements = std::span<const Measurement* const>;

/// Total number of residual rows.
Eigen::Index rows_of(Measurements z);

/// The Jacobian H of some measurements, m x n: dense in the columns of the core that are
/// used, three columns for a landmark, six for a clone. It is dense in the clones too if most
/// measurements depend on most of them. Measurements, state and scratch must outlive it; two
/// Jacobians must not share a scratch.
class Jacobian {
 public:
  struct Columns {
    int first = 0, width = 0;
  };

  Jacobian(Measurements measurements, const State& x, WhiteningScratch& scratch);

  /// result <- H M for an M with one row per error of the state.
  void times(const dense::ConstBlock& M, dense::Block result) const;

  /// result <- P H^T for a P with a column, contiguous, for every error of the state.
  void times_transpose(const dense::ConstBlock& P, dense::Block result) const;

  /// Whether the measurements depend only on clones (or imu_T_camera), densely; if so,
  /// square_of_clones gives result <- H P H^T, m x m.
  bool is_of_clones() const;
  void square_of_clones(const Covariance& covariance, dense::Block result) const;

 private:
  Measurements measurements_;
  const State& state_;
  WhiteningScratch& scratch_;
  Columns used_;  ///< of the core
  Eigen::Map<Eigen::MatrixXd, Eigen::AlignedMax> core_;
  Eigen::Map<Eigen::MatrixXd, Eigen::AlignedMax>
      clones_;  ///< columns of scratch.clone_rows, or none
};

/// With S = H P H^T + R = L L^T: W = P H^T L^-T (n x m) and w = L^-1 r, so that the correction of
/// an update is W w, its NIS is w^T w, and W W^T is subtracted from the covariance. Both are stored
/// in the scratch. If many measurements depend only on clones, W has as many columns as those have
/// errors (compression.hpp).
struct Whitened {
  dense::Block W;
  dense::Block kept;  ///< Z H^T L^-T, of further variables
  Eigen::Map<Eigen::VectorXd, Eigen::AlignedMax> w;
  double nis = 0;
};

/// r^T S^-1 r of the same; infinite if S is not positive definite. Measurements that depend only on
/// clones use only the clones' part of P.
double normalised_square(Measurements measurements, const Covariance& covariance, const State& x,
                         WhiteningScratch& scratch);

/// W, w and the NIS of an update; none if S is not positive definite. Z: the cross-covariance of
/// further variables with the state (latest_segment.hpp); it does not change the other results.
std::optional<Whitened> whiten(Measurements measurements, const Covariance& covariance,
                               const dense::ConstBlock& Z, const State& x,
                               WhiteningScratch& scratch);

}  // namespace chasles
