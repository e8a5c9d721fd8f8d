#pragma once

#include <optional>
#include <string>

#include <Eigen/Core>

/// What both kinds of batch refuse to answer: for this folder's sources alone.
namespace chasles::smooth_detail {

/// Whether positions are known, to 1 m and a tenth of the way.
class PositionCheck {
 public:
  /// The next one along the way, with its covariance.
  void add(const Eigen::Vector3d& p, const Eigen::Matrix3d& covariance);
  /// Throws InputError where one is not: what does not tell it, and what to do.
  void end(const std::string& fault, const std::string& advice) const;

 private:
  std::optional<Eigen::Vector3d> last_;
  double way_ = 0, variance_ = 0;
};

}  // namespace chasles::smooth_detail
