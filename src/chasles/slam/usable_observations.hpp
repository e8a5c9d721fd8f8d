#pragma once

#include <span>
#include <vector>

#include <chasles/camera/feature_frame.hpp>

namespace chasles {

/// The observations of a frame that a filter can use: finite, of a known camera, and of two
/// observations of one landmark in one camera the first. The frame's order is kept. It keeps its
/// memory.
class UsableObservations {
 public:
  /// `cameras`: their number. Valid until the next call, as long as the pixels are.
  const std::vector<const PixelObservation*>& among(std::span<const PixelObservation> pixels,
                                                    std::size_t cameras);
  /// The same as in the last call.
  const std::vector<const PixelObservation*>& last() const { return usable_; }

 private:
  struct Place {
    LandmarkId landmark = 0;
    int camera = 0;
    std::size_t index = 0;
  };
  std::vector<Place> places_;
  std::vector<const PixelObservation*> usable_;
};

}  // namespace chasles
