#pragma once

#include <cstddef>
#include <functional>
#include <span>

#include <nlohmann/json_fwd.hpp>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/image_frame.hpp>
#include <chasles/camera/pixel_outcome.hpp>
#include <chasles/live/live_run.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/run_folder/run.hpp>

namespace chasles {

/// Who follows a run in progress: viewers, or the progress bar of another program. Each function
/// does nothing unless it is overridden.
class SessionObserver {
 public:
  virtual ~SessionObserver() = default;

  /// Before the first frame. `known` is the part of the summary that is known then. The recording
  /// outlives the run.
  virtual void begin(const Run& /*header*/, const nlohmann::ordered_json& /*known*/,
                     const Recording& /*recording*/) {}
  /// The images of a frame. May run on another thread than the others.
  virtual void on_images(const ImageFrame&) {}
  virtual void on_frame(const FeatureFrame&) {}  ///< before it is processed
  virtual void on_outcomes(const FeatureFrame&, std::span<const PixelOutcome>) {}
  /// `frames` frames are done, which cover `recorded_seconds` [s]; `run` has new states. `map`
  /// returns what the run has found so far, which takes time.
  virtual void advance(const Run& /*run*/, std::size_t /*frames*/, double /*recorded_seconds*/,
                       const std::function<LiveMap()>& /*map*/) {}
  virtual void smoothing() {}  ///< batch estimation begins
};

}  // namespace chasles
