#pragma once

#include <optional>
#include <unordered_map>
#include <vector>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/run_folder/run.hpp>

namespace chasles {

/// Times of the first and the last observation of each landmark of a run.
class ObservationSpans {
 public:
  void add(const FeatureFrame& frame);

  /// Sets first_seen, last_seen and in_state of the landmarks. Without `in_state` all landmarks are
  /// in the state, because batch estimation retires none.
  void fill_in(const std::optional<std::vector<LandmarkId>>& in_state,
               std::vector<RunLandmark>& landmarks) const;

 private:
  struct Span {
    Time first{}, last{};
  };
  std::unordered_map<LandmarkId, Span> seen_;
};

}  // namespace chasles
