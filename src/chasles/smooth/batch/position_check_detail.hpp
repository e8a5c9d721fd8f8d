#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

/// The check for ill-posed problems of both kinds of batch. Private to this folder.
namespace chasles::smooth_detail {

/// Checks that positions are known to 1 m and a tenth of the distance travelled.
class PositionCheck {
 public:
  /// Adds the next position along the path [m], with its covariance.
  void add(const Eigen::Vector3d& p, const Eigen::Matrix3d& covariance);
  /// Throws InputError with cause and advice where one position is not known so well.
  void end(const std::string& fault, const std::string& advice) const;

 private:
  std::optional<Eigen::Vector3d> last_;
  double way_ = 0, variance_ = 0;
};

}  // namespace chasles::smooth_detail
