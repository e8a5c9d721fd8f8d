#include <algorithm>
#include <tuple>

#include <chasles/slam/usable_observations.hpp>

namespace chasles {

const std::vector<const PixelObservation*>& UsableObservations::among(
    std::span<const PixelObservation> pixels, std::size_t cameras) {
  places_.clear();
  for (std::size_t i = 0; i < pixels.size(); ++i) {
    const PixelObservation& o = pixels[i];
    const bool known_camera = o.camera >= 0 && o.camera < static_cast<int>(cameras);
    if (!known_camera || !o.pixel.allFinite()) continue;
    places_.push_back({.landmark = o.landmark, .camera = o.camera, .index = i});
  }
  const auto key = [](const Place& p) { return std::tuple(p.landmark, p.camera, p.index); };
  std::sort(places_.begin(), places_.end(),
            [&](const Place& a, const Place& b) { return key(a) < key(b); });
  const auto same = [](const Place& a, const Place& b) {
    return a.landmark == b.landmark && a.camera == b.camera;
  };
  places_.erase(std::unique(places_.begin(), places_.end(), same), places_.end());
  std::sort(places_.begin(), places_.end(),
            [](const Place& a, const Place& b) { return a.index < b.index; });
  usable_.clear();
  for (const Place& place : places_) usable_.push_back(&pixels[place.index]);
  return usable_;
}

}  // namespace chasles
