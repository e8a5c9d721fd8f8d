#pragma once

#include <Eigen/Core>

/// Covariances that may be singular. Private to this folder.
namespace chasles {

/// The roots of the diagonal; 1 where that is 0.
Eigen::VectorXd sigmas(const Eigen::MatrixXd& P);

/// L with L L^T = P: errors of 1e-6 sigmas are added, which are independent of all else.
Eigen::MatrixXd regular_root(const Eigen::MatrixXd& P);

/// Orthonormal columns whose span has those of F, to 1e-7 of the largest.
Eigen::MatrixXd range_of(const Eigen::MatrixXd& F);

}  // namespace chasles
