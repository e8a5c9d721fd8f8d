#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

namespace chasles {

/// The joint covariance of many points in little memory: P = D + U U^T. D has a block for each
/// point, U is what the points share, with a column for each of `rank` directions.
class JointCovariance {
 public:
  JointCovariance() = default;
  /// Throws UsageError for numbers of rows that do not belong together.
  JointCovariance(std::vector<Eigen::Matrix3d> own, Eigen::MatrixXd shared);

  /// How much of a covariance may be left out. The covariances of single points are exact in any
  /// case.
  struct Limits {
    double error = 0.003;  ///< root mean square of the correlations of two points that are left out
    int rank = 45;
  };
  /// Of P, symmetric and positive semidefinite, three rows a point.
  static JointCovariance of_matrix(const Eigen::MatrixXd& P, const Limits& limits);
  /// The same covariance with fewer shared directions.
  JointCovariance reduced(const Limits& limits) const;

  int points() const { return static_cast<int>(own_.size()); }
  int rank() const { return static_cast<int>(shared_.cols()); }
  const std::vector<Eigen::Matrix3d>& own() const { return own_; }
  const Eigen::MatrixXd& shared() const { return shared_; }

  /// Of one point [m^2].
  Eigen::Matrix3d of(int point) const;
  /// Of some of them together, three rows each.
  Eigen::MatrixXd of(std::span<const int> points) const;

 private:
  std::vector<Eigen::Matrix3d> own_;
  Eigen::MatrixXd shared_;  ///< three rows a point
};

/// Points that are correlated with shared errors x: x = root y with independent errors y, and the
/// first columns of the points' shared errors are by y.
struct SharedPart {
  Eigen::MatrixXd root;
  JointCovariance others;
};
/// From the covariance of x, that of the points with x, and that of the points.
SharedPart shared_part(const Eigen::MatrixXd& P_x, const Eigen::MatrixXd& P_points_x,
                       const Eigen::MatrixXd& P_points);

}  // namespace chasles
