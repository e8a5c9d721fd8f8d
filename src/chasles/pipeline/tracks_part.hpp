#pragma once

#include <cstdint>
#include <optional>

#include <chasles/camera/feature_frame.hpp>

namespace chasles {

/// The tracks that a run uses: all, or a random part of them. A track is used as a whole or not at
/// all, which depends on its number and the seed alone. Runs with different seeds show how much a
/// result depends on the choice of the tracked points. A part and its rest have no track in common.
struct TracksPart {
  std::optional<double> part = {};  ///< probability that a track is used; none: all are used
  std::uint64_t seed = 1;           ///< of the choice
  bool rest = false;                ///< the tracks that this part leaves out are used instead

  bool uses(LandmarkId track) const;
  /// Removes the other tracks.
  void thin(FeatureFrame& frame) const;
};

}  // namespace chasles
