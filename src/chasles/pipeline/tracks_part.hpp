#pragma once

#include <cstdint>
#include <optional>

#include <chasles/camera/feature_frame.hpp>

namespace chasles {

/// Which tracks a run uses: all, or a random part of them. A track is used from its first
/// observation to its last or not at all, and whether it is depends on its number and the seed
/// alone. Runs with other seeds show how much of a result is chance of which points were tracked.
struct TracksPart {
  std::optional<double> part = {};  ///< how likely a track is used; none: all are
  std::uint64_t seed = 1;           ///< chooses them

  bool uses(LandmarkId track) const;
  /// Leaves the others out.
  void thin(FeatureFrame& frame) const;
};

}  // namespace chasles
