#pragma once

#include <optional>
#include <unordered_map>
#include <vector>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/data/run.hpp>

namespace chasles::app {

/// When the landmarks of a run were seen.
class ObservationSpans {
 public:
  void add(const FeatureFrame& frame);

  /// Fills in first_seen, last_seen and in_state of landmarks. Without `in_state` all are: batch
  /// estimation retires none.
  void tell(const std::optional<std::vector<LandmarkId>>& in_state,
            std::vector<RunLandmark>& landmarks) const;

 private:
  struct Span {
    Time first{}, last{};
  };
  std::unordered_map<LandmarkId, Span> seen_;
};

}  // namespace chasles::app
