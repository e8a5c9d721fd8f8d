#pragma once

#include <cstddef>

#include <Eigen/Core>

namespace chasles {

/// How fast the errors of tracks walk, measured from whitened residuals.
///
/// The terms of a batch and of a window take errors of pixels as independent. Those of real tracks
/// are random walks (docs/noise.md), and their sum does not average out along a track. With steps
/// of h1 and h2 seconds between three consecutive residuals a, b, c of a walk of variance w per
/// second, beside any white noise,
///
///   E[|c - a|^2 / 2 - (|b - a|^2 + |c - b|^2) / 4] = w (h1 + h2) / 4    per axis,
///
/// so white noise of one variance does not count.
class ResidualWalk {
 public:
  /// Consecutive residuals of one landmark in one camera, of the same number of rows, in standard
  /// deviations, and the time from the first to the third [s]. Residuals above 2.5 and times above
  /// 2 s do not count.
  void add(const Eigen::VectorXd& first, const Eigen::VectorXd& second,
           const Eigen::VectorXd& third, double seconds);

  /// The variance of the walk per second and axis, in variances of the stated noise [1/s]: the
  /// estimate minus two of its sigmas, at least 0.
  double variance_rate() const;

  /// By what a covariance under the assumption of independent errors is too small, at least 1. A
  /// constant that is estimated from views h seconds apart over D seconds has the variance h / D,
  /// and w D / 3 if the errors walk: 1 + w D^2 / (3 h). D^2 / 3 is kWideningSquare.
  double covariance_factor() const;

 private:
  double walk_ = 0;     // sum of w (h1 + h2) / 4
  double squares_ = 0;  // of its terms
  double seconds_ = 0;  // sum of (h1 + h2) / 4
  int count_ = 0;
};

/// As of tracks of 1.7 s. Chosen on EuRoC's runs from images; held-out flights and simulated walks:
/// studies/noise.md [s^2].
inline constexpr double kWideningSquare = 1;

/// The next of these views, which have a `camera`, by the camera of view `after`; their number if
/// there is none. ResidualWalk takes only views by the camera that found the track: the noise of
/// matches differs from view to view (TrackNoise).
template <typename Views>
std::size_t next_view(const Views& views, std::size_t after) {
  std::size_t i = after + 1;
  while (i < views.size() && views[i].camera != views[after].camera) ++i;
  return i;
}

}  // namespace chasles
