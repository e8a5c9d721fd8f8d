#pragma once

#include <vector>

#include "frame_steps.hpp"
#include "single_blas.hpp"

// A frame's work in the form that the representations of a covariance need (covariance_forms.hpp).
namespace chasles::bench {

/// A frame's work in one precision. Rows of H are divided by their sigma: their noise is 1.
template <typename S>
struct Work {
  /// Columns of H for a landmark or clone, or the dependence of a new one on the pose.
  struct Part {
    Eigen::Index at = 0, row = 0;  ///< first row of H, first row of the state
    Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6> d;
  };
  MatrixOf<S> F, Q, G;        ///< Q = G^T G
  std::vector<int> keep;      ///< as in FrameStep, in this form's order
  MatrixOf<S> d_pose, noise;  ///< of all new rows: k x 6; k x k
  MatrixOf<S> noise_root;     ///< noise = noise_root^T noise_root
  MatrixOf<S> H_core;
  std::vector<Part> H_parts;
  VectorOf<S> residual;
};

/// `newest_first`: the rows after the core in the reverse order of FrameStep's. `size_before`:
/// number of rows of the state before.
template <typename S>
Work<S> work_of(const FrameStep& step, int size_before, bool newest_first);

/// G with G^T G = the semidefinite A.
Eigen::MatrixXd root(const Eigen::MatrixXd& A);

}  // namespace chasles::bench
