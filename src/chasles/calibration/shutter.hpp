#pragma once

#include <chasles/camera/rolling_shutter.hpp>
#include <chasles/codec/yaml_map.hpp>

namespace chasles {

/// The shutter of a camera by its keys `readout_time` [s] and `readout_direction`; a global one
/// without them. Throws InputError for a time that no sensor needs, and for another direction.
Shutter read_shutter(const YamlMap& map);

/// The same keys, each line after `indent`; empty for a global shutter.
std::string shutter_text(const Shutter& shutter, const std::string& indent);

/// Throws InputError, starting with `where`, for a readout [s] that no sensor needs.
double checked_readout(const std::string& where, double seconds);

}  // namespace chasles
