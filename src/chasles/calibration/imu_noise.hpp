#pragma once

#include <string>

#include <chasles/codec/yaml_map.hpp>
#include <chasles/imu/imu_sample.hpp>

namespace chasles {

/// The optional key `noise_is_exact` of a calibration file, ImuNoise::exact. Throws InputError
/// unless it is true or false.
bool read_noise_is_exact(const YamlMap& map);

/// The line that read_noise_is_exact() reads; empty if the noise is not exact.
std::string noise_is_exact_text(const ImuNoise& noise);

}  // namespace chasles
