#pragma once

#include <vector>

#include <chasles/slam/preintegration.hpp>

namespace chasles {

using Vector15d = Eigen::Matrix<double, 15, 1>;

/// What the samples between two keyframes say of their motion: the intervals, and the whitening of
/// the residual below. The mean is integrated at whatever biases are asked for, not extrapolated
/// from others; only the noise's covariance is that of the biases that the link was made with.
struct ImuLink {
  std::vector<ImuInterval> intervals;
  Matrix15d whitening = Matrix15d::Zero();  ///< lower triangular W, W^T W = covariance^-1
};

/// The covariance of [rotation, position, velocity, accelerometer bias, gyroscope bias] that the
/// noise of both sensors and their biases' random walks make of a certain state over the intervals,
/// in the axes of the IMU at their beginning: products of the exact steps (imu/strapdown.hpp).
Matrix15d link_covariance(const std::vector<ImuInterval>& intervals, const Vector6d& biases,
                          const ImuNoise& noise);

/// Throws InputError where the noise densities do not make a covariance that can be inverted: white
/// noise that is zero. A random walk below 1e-7 counts as that (it would tie two biases exactly).
ImuLink imu_link(std::vector<ImuInterval> intervals, const Vector6d& biases, const ImuNoise& noise);

/// The later keyframe against the earlier one moved by the samples, in the earlier one's axes and
/// whitened; and, where asked for, its derivatives by the reference chart's errors of both
/// [rotation, position, velocity, biases].
struct LinkDerivatives {
  Matrix15d now, next;
};
Vector15d link_residual(const ImuLink& link, const InertialState& now, const InertialState& next,
                        const Eigen::Vector3d& gravity, LinkDerivatives* derivatives = nullptr);

}  // namespace chasles
