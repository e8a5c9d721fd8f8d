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
/// for a clone; dense in the clones too where most measurements depend on most of them.
/// Measurements, state and scratch must outlive it, and two do not share a scratch.
class Jacobian {
 public:
  Jacobian(Measurements measurements, const State& x, WhiteningScratch& scratch);

  /// result <- H M for an M with a row for every error.
  void times(const dense::ConstBlock& M, dense::Block result) const;

  /// result <- P H^T, n x m, for a symmetric P, whose columns are contiguous.
  void times_transpose(const Covariance& covariance, dense::Block result) const;

  /// Whether the measurements depend on nothing but clones (or imu_T_camera), densely; and then
  /// result <- H P H^T, m x m.
  bool is_of_clones() const;
  void square_of_clones(const Covariance& covariance, dense::Block result) const;

 private:
  Measurements measurements_;
  const State& state_;
  WhiteningScratch& scratch_;
  Eigen::Map<Eigen::MatrixXd, Eigen::AlignedMax> core_;
  Eigen::Map<Eigen::MatrixXd, Eigen::AlignedMax>
      clones_;  ///< columns of scratch.clone_rows, or none
};

/// With S = H P H^T + R = L L^T: W = P H^T L^-T (n x m) and w = L^-1 r, so that the correction of
/// an update is W w, its NIS w^T w, and the covariance loses W W^T. Both stand in the scratch.
/// Where many measurements are of clones alone W and w have as many columns as those have errors
/// (compression.hpp).
struct Whitened {
  Eigen::Map<Eigen::MatrixXd, Eigen::AlignedMax> W;
  Eigen::Map<Eigen::VectorXd, Eigen::AlignedMax> w;
  double nis = 0;
};

/// r^T S^-1 r of the same; infinite where S is not positive definite. What measurements of clones
/// alone say is found from the clones' part of P.
double normalised_square(Measurements measurements, const Covariance& covariance, const State& x,
                         WhiteningScratch& scratch);

/// None where S is not positive definite.
std::optional<Whitened> whiten(Measurements measurements, const Covariance& covariance,
                               const State& x, WhiteningScratch& scratch);

}  // namespace chasles
