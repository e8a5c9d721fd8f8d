#pragma once

#include <vector>

#include "frame_work.hpp"

// Representations of a covariance, for the same frames (square_root_bench.cpp).
namespace chasles::bench {

/// P = covariance, both triangles: the filter's own algorithm in either precision.
template <typename S>
class DenseForm {
 public:
  static constexpr bool kNewestFirst = false;
  explicit DenseForm(const Eigen::MatrixXd& core_covariance);

  void propagate(const Work<S>& w);
  void exchange(const Work<S>& w);  ///< drop and add
  bool update(const Work<S>& w);  ///< false if S is not positive definite; nothing is changed then

  Eigen::MatrixXd covariance() const;
  const VectorOf<S>& correction() const { return correction_; }

 private:
  auto all() { return P_.topLeftCorner(size_, size_); }
  void apply_H(const Work<S>& w, Eigen::Index first, const MatrixOf<S>& M, MatrixOf<S>& HM) const;
  bool whiten(const Work<S>& w, Eigen::Index first, BlockOf<S> W, Eigen::Ref<VectorOf<S>> e) const;

  MatrixOf<S> P_;
  int core_ = 0, size_ = 0;
  VectorOf<S> correction_;
};

/// P = U^T U, U lower triangular, with a column for each row of the state: the core first, then
/// from the newest to the oldest. So the core's rows of U are zero outside the core, and
///   propagation changes the core's columns and a triangle of its size;
///   new rows are next to the core, and form a triangle of their own size;
///   dropped columns leave steps, which rotations from the right remove;
///   with A = U H^T (H of noise 1) and I + A A^T = L L^T, P - P H^T S^-1 H P = (L^-1 U)^T (L^-1 U),
///   where L^-1 U is lower triangular again, and the correction is (L^-1 U)^T L^-1 A r.
/// The change of chart after an update (Ekf::change_chart) is not included.
template <typename S>
class RootForm {
 public:
  static constexpr bool kNewestFirst = true;
  explicit RootForm(const Eigen::MatrixXd& core_covariance);

  void propagate(const Work<S>& w);
  void exchange(const Work<S>& w);
  bool update(const Work<S>& w);

  Eigen::MatrixXd covariance() const;  ///< rows in this form's order
  const VectorOf<S>& correction() const { return correction_; }

 private:
  auto all() { return U_.bottomRightCorner(size_, size_); }
  void drop(const std::vector<int>& keep);
  void add(const Work<S>& w);

  MatrixOf<S> U_;  ///< in its lower right corner, because it grows there
  MatrixOf<S> A_,
      L_;  ///< workspace of an update, kept because allocating pages takes longer than the algebra
  int core_ = 0, size_ = 0;
  VectorOf<S> correction_;
};

}  // namespace chasles::bench
