#include "live_frames.hpp"

#include <utility>

namespace chasles::app {

void LiveFrames::on_images(const ImageFrame& images) {
  if (!service_.shows_frames()) return;
  const std::lock_guard lock(mutex_);
  if (!pictures_ && service_.claim_frame()) pictures_ = images;
}

// Pictures that have passed are of a frame that was dropped, as in real time.
std::optional<ImageFrame> LiveFrames::take_pictures(Time time) {
  const std::lock_guard lock(mutex_);
  if (!pictures_ || pictures_->time > time) return std::nullopt;
  std::optional<ImageFrame> pictures = std::exchange(pictures_, std::nullopt);
  if (pictures->time < time) pictures.reset();
  return pictures;
}

void LiveFrames::on_frame(const FeatureFrame& frame) {
  finish();
  if (!service_.shows_frames()) return trails_.clear();
  trails_.follow(frame);
  if (has_pictures_) {
    std::optional<ImageFrame> pictures = take_pictures(frame.time);
    if (!pictures) return;
    shown_pictures_ = std::move(pictures->images);
  } else if (!service_.claim_frame()) {
    return;
  }
  shown_ = frame.time;
  features_ = trails_.features(frame);
}

void LiveFrames::on_outcomes(const FeatureFrame& frame, std::span<const PixelOutcome> outcomes) {
  if (shown_ != frame.time) return;
  for (const PixelOutcome& one : outcomes) {
    const auto found = features_.find({one.observation.camera, one.observation.landmark});
    if (found != features_.end()) found->second.seen = one;
  }
}

void LiveFrames::finish() {
  if (!shown_) return;
  FoxgloveFrame frame{.images = {}, .pictures = std::exchange(shown_pictures_, {})};
  for (std::size_t k = 0; k < cameras_.size(); ++k) {
    frame.images.push_back({.time = *shown_,
                            .camera = static_cast<int>(k),
                            .width = cameras_[k].width,
                            .height = cameras_[k].height,
                            .jpeg = {},
                            .features = {}});
  }
  for (const auto& [key, feature] : features_) {
    frame.images[static_cast<std::size_t>(key.first)].features.push_back(feature);
  }
  service_.frame(std::move(frame));
  shown_.reset();
}

}  // namespace chasles::app
