#include <chasles/slam/imu_in_use.hpp>

namespace chasles {

ImuNoise noise_in_use(const InertialSlamSettings& settings, const ImuNoise& stated) {
  return scaled(stated, settings.imu_noise_scale.value_or(1));
}

ImuBuffer::Options imu_in_use(const InertialSlamSettings& settings, ImuBuffer::Options imu) {
  imu.vibration_noise = settings.vibration_noise.value_or(0);
  return imu;
}

}  // namespace chasles
