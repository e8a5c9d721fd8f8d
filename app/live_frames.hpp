#pragma once

#include <map>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include <chasles/foxglove/service.hpp>
#include <chasles/pipeline/run.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/session/feature_trails.hpp>

namespace chasles::app {

/// Shows frames of a run, as one of its observers, with the tracked points and their outcomes, to
/// clients that want to see them. Without such a client it does nothing. A frame is given away when
/// the next one comes, because only then all its points have an outcome.
class LiveFrames : public RunObserver {
 public:
  /// Both must outlive it.
  LiveFrames(const std::vector<Camera>& cameras, bool pictures, FoxgloveService& service)
      : cameras_(cameras), has_pictures_(pictures), service_(service) {}

  /// Copies the pictures if they are wanted.
  void on_images(const ImageFrame& images) override;
  void on_frame(const FeatureFrame& frame) override;
  void on_outcomes(const FeatureFrame& frame, std::span<const PixelOutcome> outcomes) override;

  /// Gives the last frame away.
  void finish();

 private:
  std::optional<ImageFrame> take_pictures(Time time);

  const std::vector<Camera>& cameras_;
  const bool has_pictures_;
  FoxgloveService& service_;
  FeatureTrails trails_;
  /// The points of the frame that is being processed, if it is to be shown, and its pictures.
  std::optional<Time> shown_;
  std::map<FeatureTrails::Key, ImageFeature> features_;
  std::vector<GrayImage> shown_pictures_;

  std::mutex mutex_;  ///< guards pictures_
  std::optional<ImageFrame> pictures_;
};

}  // namespace chasles::app
