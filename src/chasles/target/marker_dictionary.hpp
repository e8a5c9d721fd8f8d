#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <chasles/target/target.hpp>

namespace chasles {

/// The codes of square black and white markers.
struct MarkerDictionary {
  std::string_view name;  ///< OpenCV's, e.g. "DICT_5X5_100"
  int side = 0;           ///< bits along a side, without the border
  /// Bits row by row from the upper left corner, the first one highest; 1 is white. As OpenCV has
  /// them: its AprilTags are turned by half a turn against those of the AprilTag library.
  std::span<const std::uint64_t> codes;
};

/// OpenCV's names of the dictionaries.
std::vector<std::string> dictionary_names();

/// Throws UsageError for an unknown name.
MarkerDictionary marker_dictionary(const std::string& name);

/// The dictionary of a target with tags.
MarkerDictionary target_dictionary(const Target& target);

/// The code of the marker turned counterclockwise by a quarter of a turn.
std::uint64_t turned(std::uint64_t code, int side);

}  // namespace chasles
