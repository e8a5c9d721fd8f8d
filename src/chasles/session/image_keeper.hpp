#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <chasles/camera/image_frame.hpp>
#include <chasles/camera/pixel_outcome.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/run_folder/shown_images.hpp>
#include <chasles/session/feature_trails.hpp>

namespace chasles {

/// Keeps some frames of a run for viewing: small pictures, the tracked points and their outcomes.
/// Without `every` it does nothing.
class ImageKeeper {
 public:
  /// Approximate number of frames that are kept by default.
  static constexpr std::size_t kFrames = 200;
  static constexpr int kWidth = 480;  ///< largest width of a picture [px]

  /// Keeps the first of every `every` frames; 0: about kFrames frames; empty: none.
  ImageKeeper(const Recording& recording, std::optional<int> every);

  /// Stores the pictures of a frame. May run on another thread than the other functions.
  void see(const ImageFrame& images);
  /// Stores the tracks of a frame. Must get every frame, in time order.
  void follow(const FeatureFrame& frame);
  /// Stores the outcomes of a frame's observations.
  void note_outcomes(const FeatureFrame& frame, std::span<const PixelOutcome> outcomes);

  /// Returns the kept frames. see() must not be called afterwards.
  std::vector<ShownImage> take();

 private:
  using Features = std::map<FeatureTrails::Key, ImageFeature>;

  bool is_kept(Time time) const;
  ShownImage image(Time time, int camera) const;

  std::vector<Camera> cameras_;
  std::vector<Time> kept_;                             ///< ascending
  std::map<Time, std::vector<std::string>> pictures_;  ///< one per camera
  std::map<Time, Features> features_;
  FeatureTrails trails_;
};

}  // namespace chasles
