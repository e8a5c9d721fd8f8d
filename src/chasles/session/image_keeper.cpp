#include <algorithm>

#include <chasles/codec/image_encode.hpp>
#include <chasles/session/image_keeper.hpp>

namespace chasles {

ImageKeeper::ImageKeeper(const Recording& recording, std::optional<int> every)
    : cameras_(recording.cameras) {
  if (!every) return;
  const std::size_t frames = frame_count(recording);
  const std::size_t step =
      *every > 0 ? static_cast<std::size_t>(*every) : (frames + kFrames - 1) / kFrames;
  for (std::size_t i = 0; i < frames; i += step) kept_.push_back(frame_time(recording, i));
}

bool ImageKeeper::is_kept(Time time) const {
  return std::binary_search(kept_.begin(), kept_.end(), time);
}

void ImageKeeper::on_images(const ImageFrame& images) {
  if (!is_kept(images.time)) return;
  std::vector<std::string> pictures;
  for (const GrayImage& image : images.images) pictures.push_back(jpeg_bytes(image, kWidth));
  pictures_.emplace(images.time, std::move(pictures));
}

void ImageKeeper::on_frame(const FeatureFrame& frame) {
  if (kept_.empty()) return;
  trails_.follow(frame);
  if (is_kept(frame.time)) features_[frame.time] = trails_.features(frame);
}

void ImageKeeper::on_outcomes(const FeatureFrame& frame, std::span<const PixelOutcome> outcomes) {
  const auto features = features_.find(frame.time);
  if (features == features_.end()) return;
  for (const PixelOutcome& one : outcomes) {
    const auto found = features->second.find({one.observation.camera, one.observation.landmark});
    if (found != features->second.end()) found->second.seen = one;
  }
}

ShownImage ImageKeeper::image(Time time, int camera) const {
  const Camera& of = cameras_[static_cast<std::size_t>(camera)];
  ShownImage image{.time = time,
                   .camera = camera,
                   .width = of.width,
                   .height = of.height,
                   .jpeg = {},
                   .features = {}};
  const auto pictures = pictures_.find(time);
  if (pictures != pictures_.end()) {
    image.jpeg = pictures->second[static_cast<std::size_t>(camera)];
  }
  for (const auto& [key, feature] : features_.at(time)) {
    if (key.first == camera) image.features.push_back(feature);
  }
  return image;
}

std::vector<ShownImage> ImageKeeper::take() {
  std::vector<ShownImage> images;
  for (const auto& [time, features] : features_) {
    for (int camera = 0; camera < std::ssize(cameras_); ++camera) {
      images.push_back(image(time, camera));
    }
  }
  return images;
}

}  // namespace chasles
