#pragma once

#include <map>
#include <utility>
#include <vector>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/run_folder/shown_images.hpp>

namespace chasles {

/// Where the tracked points were in the last frames: their age, and their tails in a picture.
class FeatureTrails {
 public:
  static constexpr int kTail = 5;  ///< age of ImageFeature::before, in frames

  /// A feature's camera and landmark.
  using Key = std::pair<int, LandmarkId>;

  /// Must get every frame, in time order.
  void follow(const FeatureFrame& frame);
  /// The points of the frame that was followed last, without an outcome yet.
  std::map<Key, ImageFeature> features(const FeatureFrame& frame) const;
  void clear() { trails_.clear(); }

 private:
  struct Trail {
    int age = 0, seen = 0;              ///< [frames]; number of the last frame
    std::vector<Eigen::Vector2d> last;  ///< at most kTail + 1 pixels [px]
  };

  std::map<Key, Trail> trails_;
  int frame_ = 0;
};

}  // namespace chasles
