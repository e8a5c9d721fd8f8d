#pragma once

#include <vector>

#include <chasles/smooth/batch/problem_blocks_detail.hpp>
#include <chasles/smooth/batch/selected_inverse.hpp>

/// Private to this folder.
namespace chasles::smooth_detail {

/// Rows of a problem's errors that its search holds, and the covariance of these errors. `share`:
/// of it, for what depends on them: a covariance that is multiplied by a factor afterwards needs
/// the inverse of that.
struct ConsideredErrors {
  std::vector<int> rows = {};
  Eigen::MatrixXd covariance = {};
  double share = 1;
};

/// The covariance of the errors of a problem at its minimum. Errors that are considered add what
/// they do to the minimum: S C S^T, S = -H^-1 H_c, of the normal matrix H of the others and its
/// columns H_c by the considered ones.
class ErrorCovariance {
 public:
  /// `equations`: of a problem whose errors are all free. Throws as SelectedInverse.
  ErrorCovariance(NormalEquations equations, ConsideredErrors considered,
                  const std::function<bool()>& stop);

  /// Of these rows. They must be among those of a residual.
  Eigen::MatrixXd block(const std::vector<int>& rows) const {
    return block(rows, considered_.share);
  }
  Eigen::MatrixXd block(const std::vector<int>& rows, double share) const;
  /// g^T H^-1 g of the gradient and the normal matrix, but for considered errors.
  double squared_distance() const { return squared_distance_; }

 private:
  Eigen::MatrixXd take_columns(NormalEquations& equations) const;

  ConsideredErrors considered_;
  Eigen::MatrixXd by_considered_;  // S; the identity in its own rows
  SelectedInverse inverse_;
  double squared_distance_ = 0;
};

}  // namespace chasles::smooth_detail
