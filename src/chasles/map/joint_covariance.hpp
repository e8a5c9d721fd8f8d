#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

namespace chasles {

/// The joint covariance of many points in little memory: a block of its own for each point, and
/// what they share, P = D + U U^T. D is block-diagonal, U has `rank` columns.
///
/// The blocks of single points are exact. A covariance of two points lacks what neither of the
/// `rank` shared directions explains; `error` bounds what is typical of that (docs/map.md).
class JointCovariance {
 public:
  JointCovariance() = default;
  /// Throws UsageError for numbers of rows that do not belong together.
  JointCovariance(std::vector<Eigen::Matrix3d> own, Eigen::MatrixXf shared);

  /// Of P, symmetric and positive semidefinite, three rows a point: as many shared directions as
  /// leave a root mean square below `error` in the correlations of two points, `most` at most.
  static JointCovariance compressed(const Eigen::MatrixXd& P, double error = 0.003, int most = 48);

  int points() const { return static_cast<int>(own_.size()); }
  int rank() const { return static_cast<int>(shared_.cols()); }
  const std::vector<Eigen::Matrix3d>& own() const { return own_; }
  const Eigen::MatrixXf& shared() const { return shared_; }

  /// The same of some of the points.
  JointCovariance part(std::span<const int> points) const;

  /// Of one point [m^2].
  Eigen::Matrix3d of(int point) const;
  /// Of some of them together, three rows each.
  Eigen::MatrixXd of(std::span<const int> points) const;

 private:
  std::vector<Eigen::Matrix3d> own_;
  Eigen::MatrixXf shared_;  ///< three rows a point
};

}  // namespace chasles
