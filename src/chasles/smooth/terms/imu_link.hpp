#pragma once

#include <vector>

#include <chasles/imu/imu_correction.hpp>
#include <chasles/initialise/preintegration.hpp>

namespace chasles {

using Vector15d = Eigen::Matrix<double, 15, 1>;

/// The samples between two keyframes as a term: the intervals, and the whitening of the residual
/// below. The mean is integrated exactly at the given biases, not extrapolated. Only the covariance
/// of the noise is that at the biases with which the link was made.
struct ImuLink {
  std::vector<ImuInterval> intervals;
  Matrix15d whitening = Matrix15d::Zero();  ///< lower triangular W, W^T W = covariance^-1
};

/// The covariance of [rotation, position, velocity, accelerometer bias, gyroscope bias] after the
/// intervals, from an exact state, due to the noise of both sensors and the random walks of their
/// biases; in the IMU axes at the beginning. A product of the exact steps (imu/strapdown.hpp).
Matrix15d link_covariance(const std::vector<ImuInterval>& intervals, const Vector6d& biases,
                          const ImuNoise& noise);

/// Throws InputError where the covariance is not invertible because white noise is zero. A random
/// walk below 1e-7 is replaced by 1e-7 (a smaller one would tie two biases exactly).
ImuLink imu_link(std::vector<ImuInterval> intervals, const Vector6d& biases, const ImuNoise& noise);

/// The residual: the later keyframe against the prediction from the earlier one by the samples, in
/// the earlier one's axes and whitened. Optionally its derivatives by the reference chart's errors
/// of both [rotation, position, velocity, biases].
struct LinkDerivatives {
  Matrix15d now, next;
};
Vector15d link_residual(const ImuLink& link, const InertialState& now, const InertialState& next,
                        const Eigen::Vector3d& gravity, LinkDerivatives* derivatives = nullptr);

/// The link by samples that an IMU's parameters correct, where that of `measured` has them as they
/// are; the whitening is the same.
ImuLink corrected(const ImuCorrection& imu, const ImuLink& measured);

/// The derivative of the residual of corrected(imu, measured) by the parameters, whitened: 15 x
/// ImuCorrection::size(). An error of a sample acts like one of its bias with the other sign
/// (docs/derivations.md, D66).
using LinkByImu = Eigen::Matrix<double, 15, Eigen::Dynamic, 0, 15, ImuCorrection::kMost>;
LinkByImu link_by_imu(const ImuLink& measured, const ImuCorrection& imu, const InertialState& now,
                      const InertialState& next);

}  // namespace chasles
