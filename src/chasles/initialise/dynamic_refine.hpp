#pragma once

#include <optional>
#include <vector>

#include <chasles/initialise/dynamic_linear.hpp>
#include <chasles/initialise/dynamic_system.hpp>

namespace chasles {

/// Covariance of [tilt x, tilt y, velocity 3, accelerometer bias 3, gyroscope bias 3] at keyframe
/// 0, nav axes.
using Matrix11d = Eigen::Matrix<double, 11, 11>;

/// The most probable motion of a window, and its uncertainty.
struct RefinedMotion {
  MotionUnknowns motion;
  Matrix11d covariance = Matrix11d::Zero();  ///< posterior, including the prior of the biases
  double misfit = 0;                         ///< squared pixel residuals per degree of freedom
  double distance = 0;        ///< to the end of the next step, in posterior standard deviations
  int views = 0, tracks = 0;  ///< those that fit
};

/// Least squares over keyframes, biases and points, with Levenberg's damping. Pixels have a Huber
/// loss. The samples between two keyframes have the white noise of the strapdown model. The biases
/// are constant over the window and have a prior. After convergence, views that do not fit are
/// removed and the search is repeated. None where too few tracks remain or the equations are
/// singular.
std::optional<RefinedMotion> refine_motion(MotionWindow window, const LinearMotion& linear,
                                           const Vector6d& biases, const Vector6d& bias_sigma,
                                           const ImuNoise& noise, double gravity);

}  // namespace chasles
