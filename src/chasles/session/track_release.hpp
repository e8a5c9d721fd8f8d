#pragma once

#include <cstddef>

#include <chasles/pipeline/run.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

/// Gives up a recording's tracks as a run passes them: the path and the map that grow meanwhile
/// take their memory. Times and number of the frames stay. Until the first estimate all tracks
/// stay, because the diagnosis of a run that never starts looks at them.
class TrackRelease : public RunObserver {
 public:
  /// The recording must outlive it.
  explicit TrackRelease(Recording& recording) : recording_(recording) {}

  void on_frame(const FeatureFrame& frame) override;
  void on_estimate(const Estimate&, const EstimateTiming&) override { started_ = true; }

 private:
  Recording& recording_;
  bool started_ = false;
  std::size_t released_ = 0;  ///< of the frames, from the first
  std::size_t bytes_ = 0;     ///< of tracks since their memory was last given back
};

}  // namespace chasles
