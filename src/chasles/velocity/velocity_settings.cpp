#include <chasles/base/validate.hpp>
#include <chasles/velocity/velocity_settings.hpp>

namespace chasles {

void validate(const VelocitySlamSettings& s) {
  validate_fields(s);
  const bool state = s.mode == SlamMode::kSlam && s.velocity == VelocityRole::kMeasured;
  if (s.velocity_axes == VelocityAxes::kLevel && !state) {
    throw UsageError(
        "velocity_axes=level estimates the IMU's tilt: expected mode=slam and velocity=measured");
  }
  if (s.map_memory > 0 && !s.compress_map) {
    throw UsageError(
        "map_memory bounds the memory of a compressed map: expected compress_map=true");
  }
}

}  // namespace chasles
