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
#include <chasles/data/recording.hpp>
#include <chasles/data/run_images.hpp>

namespace CLI {
class App;
}

namespace chasles::app {

/// --keep-images [N].
void declare_keep_images(CLI::App& parser, std::optional<int>& every);

/// Keeps some frames of a run to be looked at: small pictures, the points that were followed into
/// them, and what became of those. One that was asked for nothing does nothing.
class ImageKeeper {
 public:
  /// Without another wish so few frames are kept that there are about so many.
  static constexpr std::size_t kFrames = 200;
  static constexpr int kWidth = 480;  ///< of a picture [px]
  static constexpr int kTail = 5;     ///< frames back that RunFeature::before is from

  /// Keeps the first of every `every` frames; 0: as many as make kFrames. None: nothing.
  ImageKeeper(const Recording& recording, std::optional<int> every);

  /// The pictures of a frame; may be called from another thread than the others.
  void see(const ImageFrame& images);
  /// Every frame, in the order of time.
  void follow(const FeatureFrame& frame);
  /// What the filter made of a frame.
  void judge(const FeatureFrame& frame, std::span<const PixelOutcome> judged);

  /// What was kept. Nobody may see() any more.
  std::vector<RunImage> take();

 private:
  struct Trail {
    int age = 0, seen = 0;              ///< frames; the last one
    std::vector<Eigen::Vector2d> last;  ///< kTail + 1 of them at most [px]
  };
  using Features = std::map<std::pair<int, LandmarkId>, RunFeature>;  ///< by camera

  bool is_kept(Time time) const;
  RunFeature feature(const PixelObservation& seen, const Trail& trail) const;
  RunImage image(Time time, int camera) const;

  std::vector<Camera> cameras_;
  std::vector<Time> kept_;                             ///< rising
  std::map<Time, std::vector<std::string>> pictures_;  ///< a camera each
  std::map<Time, Features> features_;
  std::map<std::pair<int, LandmarkId>, Trail> trails_;
  int frame_ = 0;
};

}  // namespace chasles::app
