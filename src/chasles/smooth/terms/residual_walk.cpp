#include <algorithm>
#include <cmath>

#include <chasles/smooth/terms/residual_walk.hpp>

namespace chasles {
namespace {

constexpr double kLargest = 2.5;  // an outlier says nothing of the others
constexpr double kLongest = 2;    // a landmark that returns is another track [s]
constexpr double kSigmas = 2;     // white noise then has no rate, but for one run in 40
// Two thirds of the differences of a triple are those of its neighbours.
constexpr double kOverlap = 3;

}  // namespace

void ResidualWalk::add(const Eigen::VectorXd& first, const Eigen::VectorXd& second,
                       const Eigen::VectorXd& third, double seconds) {
  const bool near = first.norm() <= kLargest && second.norm() <= kLargest &&
                    third.norm() <= kLargest;  // not for NaN
  if (!(near && seconds > 0 && seconds <= kLongest)) return;
  const double steps = (second - first).squaredNorm() + (third - second).squaredNorm();
  const double walk = ((third - first).squaredNorm() / 2 - steps / 4) /
                      static_cast<double>(std::max<Eigen::Index>(first.size(), 1));
  walk_ += walk;
  squares_ += walk * walk;
  seconds_ += seconds / 4;
  ++count_;
}

double ResidualWalk::variance_rate() const {
  if (!(seconds_ > 0)) return 0;
  return std::max(walk_ - kSigmas * std::sqrt(kOverlap * squares_), 0.0) / seconds_;
}

double ResidualWalk::covariance_factor() const {
  if (count_ == 0) return 1;
  const double step = 2 * seconds_ / count_;
  return 1 + kWideningSquare * variance_rate() / step;
}

}  // namespace chasles
