#include <chasles/numeric/random.hpp>
#include <chasles/pipeline/tracks_part.hpp>

namespace chasles {

bool TracksPart::uses(LandmarkId track) const {
  const auto number = static_cast<std::uint64_t>(track);
  return !part || (Random{.seed = seed}.uniform(Stream::kTrackKept, number) < *part) != rest;
}

void TracksPart::thin(FeatureFrame& frame) const {
  if (!part) return;
  const auto unused = [&](const auto& observation) { return !uses(observation.landmark); };
  std::erase_if(frame.observations, unused);
  std::erase_if(frame.pixels, unused);
}

}  // namespace chasles
