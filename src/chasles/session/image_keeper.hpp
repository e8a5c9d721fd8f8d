#pragma once

#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <chasles/pipeline/run.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/run_folder/shown_images.hpp>
#include <chasles/session/feature_trails.hpp>

namespace chasles {

/// Keeps some frames of a run for viewing, as one of its observers: small pictures, the tracked
/// points and their outcomes. Without `every` it does nothing.
class ImageKeeper : public RunObserver {
 public:
  /// Approximate number of frames that are kept by default.
  static constexpr std::size_t kFrames = 200;
  static constexpr int kWidth = 480;  ///< largest width of a picture [px]

  /// Keeps the first of every `every` frames; 0: about kFrames frames; empty: none.
  ImageKeeper(const Recording& recording, std::optional<int> every);

  void on_images(const ImageFrame& images) override;
  void on_frame(const FeatureFrame& frame) override;
  void on_outcomes(const FeatureFrame& frame, std::span<const PixelOutcome> outcomes) override;

  /// Returns the kept frames. Nothing may be observed afterwards.
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
