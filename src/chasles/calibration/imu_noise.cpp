#include <chasles/calibration/imu_noise.hpp>

namespace chasles {
namespace {

constexpr const char* kKey = "noise_is_exact";

}  // namespace

bool read_noise_is_exact(const YamlMap& map) {
  return map.has(kKey) && map.flag(kKey, "the IMU is simulated with this noise");
}

std::string noise_is_exact_text(const ImuNoise& noise) {
  if (!noise.exact) return {};
  return std::string("# The IMU is simulated with this noise, and its vibrations add none.\n") +
         kKey + ": true\n";
}

}  // namespace chasles
