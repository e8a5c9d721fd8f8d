#pragma once

#include <optional>
#include <vector>

#include <chasles/slam/dynamic_linear.hpp>
#include <chasles/slam/dynamic_system.hpp>

namespace chasles {

/// Of [tilt x, tilt y, velocity 3, accelerometer bias 3, gyroscope bias 3] at keyframe 0, nav axes.
using Matrix11d = Eigen::Matrix<double, 11, 11>;

/// The most probable motion of a window, and how well the window tells it.
struct RefinedMotion {
  WindowMotion motion;
  Matrix11d covariance = Matrix11d::Zero();  ///< posterior, with the prior of the biases
  double misfit = 0;                         ///< squared pixel residuals per degree of freedom
  double distance = 0;        ///< from where the next step would end, in posterior deviations
  int views = 0, tracks = 0;  ///< that fit
};

/// Least squares over keyframes, biases and points: every pixel by Huber, the samples between two
/// keyframes with the white noise that strapdown gives them, the biases by their prior, constant
/// over the window. Levenberg's damping; views that do not fit then leave, and it is repeated. None
/// where too few tracks are left or the equations are singular.
std::optional<RefinedMotion> refine_motion(MotionWindow window, const LinearMotion& linear,
                                           const Vector6d& biases, const Vector6d& bias_sigma,
                                           const ImuNoise& noise, double gravity);

}  // namespace chasles
