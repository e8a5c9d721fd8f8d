#pragma once

#include <deque>

#include <chasles/initialise/inertial_start.hpp>

namespace chasles {

/// What errors of the IMU's parameters do to an initialisation, which took the samples as corrected
/// by `calibration`: sets InertialStart::by_imu, and enlarges the covariance for the part that the
/// mean of the samples does not explain. `samples`: as measured, in order of time.
///
/// With f, w the means of the samples, D their derivatives by the parameters, and z nav's vertical,
///   theta = R D_f x z / g,   b_a = R^T z z^T R D_f,   b_g = D_w,
/// as at a standstill: the force gives roll, pitch and the bias along gravity, and the rate the
/// other bias (docs/derivations.md, D67). The variation of the samples acts on tilt, velocity and
/// biases as in widen_start.
void widen_start_by_imu(const Calibration& calibration, const std::deque<ImuSample>& samples,
                        InertialStart& start);

}  // namespace chasles
