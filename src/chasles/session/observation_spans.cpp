#include <unordered_set>

#include <chasles/session/observation_spans.hpp>

namespace chasles {

void ObservationSpans::add(const FeatureFrame& frame) {
  const auto note = [&](LandmarkId id) {
    seen_.try_emplace(id, Span{frame.time, frame.time}).first->second.last = frame.time;
  };
  for (const StereoObservation& o : frame.observations) note(o.landmark);
  for (const PixelObservation& o : frame.pixels) note(o.landmark);
}

void ObservationSpans::fill_in(const std::optional<std::vector<LandmarkId>>& in_state,
                               std::vector<RunLandmark>& landmarks) const {
  std::unordered_set<LandmarkId> present;
  if (in_state) present.insert(in_state->begin(), in_state->end());
  for (RunLandmark& l : landmarks) {
    const auto found = seen_.find(l.id);
    if (found != seen_.end()) {
      l.first_seen = found->second.first;
      l.last_seen = found->second.last;
    }
    l.in_state = !in_state || present.contains(l.id);
  }
}

}  // namespace chasles
