#include <algorithm>
#include <cmath>

#include <chasles/base/error.hpp>
#include <chasles/smooth/batch/position_check_detail.hpp>

namespace chasles::smooth_detail {

void PositionCheck::add(const Eigen::Vector3d& p, const Eigen::Matrix3d& covariance) {
  if (last_) way_ += (p - *last_).norm();
  last_ = p;
  variance_ = std::max(variance_, covariance.trace());
}

void PositionCheck::end(const std::string& fault, const std::string& advice) const {
  const double sigma = std::sqrt(variance_), limit = 1 + 0.1 * way_;
  if (sigma <= limit) return;
  throw InputError("the problem is ill-posed: " + fault + ", and a position is uncertain by " +
                   std::to_string(sigma) + " m (expected at most " + std::to_string(limit) +
                   " m): " + advice);
}

}  // namespace chasles::smooth_detail
