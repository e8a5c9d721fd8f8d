#pragma once

#include <vector>

#include <chasles/loop/merge_maps.hpp>

namespace chasles {

/// Parts of maps by what they have in common: a map and its extensions are a family, and so are
/// extensions of these.
struct MapFamilies {
  /// One part of each family, its extensions joined (map_extensions.hpp), in the order of parts.
  std::vector<MapPart> joined;
  /// Of which they follow, each once, in their order: by the begin and the name of their first
  /// sessions. A map that has one extension alone is not among them, because that has all of it.
  std::vector<LandmarkMap> parts;
};

/// Whether they are the same to the last bit.
bool is_same_map(const LandmarkMap& x, const LandmarkMap& y);

/// Independent of the order of the parts. Throws InputError where two parts have a session of one
/// recording in any other way.
MapFamilies map_families(std::vector<MapPart> parts);

}  // namespace chasles
