#include <iterator>

#include <chasles/session/feature_trails.hpp>

namespace chasles {
namespace {

// A track without observation for longer has ended; every front end drops it earlier.
constexpr int kWaiting = 20;  // frames

}  // namespace

void FeatureTrails::follow(const FeatureFrame& frame) {
  ++frame_;
  for (const PixelObservation& seen : frame.pixels) {
    Trail& trail = trails_[{seen.camera, seen.landmark}];
    ++trail.age;
    trail.seen = frame_;
    if (std::ssize(trail.last) > kTail) trail.last.erase(trail.last.begin());
    trail.last.push_back(seen.pixel);
  }
  std::erase_if(trails_, [&](const auto& entry) { return frame_ - entry.second.seen > kWaiting; });
}

std::map<FeatureTrails::Key, ImageFeature> FeatureTrails::features(
    const FeatureFrame& frame) const {
  std::map<Key, ImageFeature> features;
  for (const PixelObservation& seen : frame.pixels) {
    const Key key(seen.camera, seen.landmark);
    const Trail& trail = trails_.at(key);
    ImageFeature feature{.seen = {.observation = seen}, .age = trail.age};
    if (trail.last.size() > 1) feature.before = trail.last.front();
    features.emplace(key, feature);
  }
  return features;
}

}  // namespace chasles
