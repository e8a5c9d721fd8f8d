#pragma once

#include <chasles/imu/imu_buffer.hpp>
#include <chasles/slam/inertial_settings.hpp>

namespace chasles {

/// The IMU as all estimators of a visual-inertial run use it: the stated noise with
/// imu_noise_scale, and the samples with vibration_noise.
ImuNoise noise_in_use(const InertialSlamSettings& settings, const ImuNoise& stated);
ImuBuffer::Options imu_in_use(const InertialSlamSettings& settings, ImuBuffer::Options imu);

}  // namespace chasles
