#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/base/interruption.hpp>
#include <chasles/frontend/frontend.hpp>
#include <chasles/pipeline/liveliest_part.hpp>
#include <chasles/recording/masks.hpp>
#include <chasles/session/check_tracks.hpp>
#include <chasles/session/progress.hpp>

namespace chasles {
namespace {

constexpr std::size_t kPairs = 40;  // image pairs of two cameras
constexpr Time kNextInstant = std::chrono::milliseconds(50);

ImageFrame read(const ImageSource& images, std::size_t i, std::size_t cameras) {
  try {  // the exposure check counts what cannot be read
    return images.read_undamaged(i, cameras, [](const InputError&) {});
  } catch (const InputError&) {
    return {.time = images.time(i), .images = std::vector<GrayImage>(cameras)};
  }
}

// Adds observations with landmark ids that no other source uses.
struct Source {
  int camera = 0;
  LandmarkId source = 0, sources = 1;

  void add(const FeatureFrame& seen, FeatureFrame& frame) const {
    for (const PixelObservation& o : seen.pixels) {
      frame.pixels.push_back(
          {.landmark = o.landmark * sources + source, .camera = camera, .pixel = o.pixel});
    }
  }
};

/// Tracks features in each camera of a rig separately, and from one camera to another.
class Tracker {
 public:
  /// `masks`: none, or one per camera.
  Tracker(const std::vector<Camera>& cameras, const FrontendSettings& settings,
          std::vector<GrayImage> masks)
      : cameras_(&cameras), alone_(settings), masks_(std::move(masks)) {
    alone_.stereo = false;
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      frontends_.emplace_back(alone_, std::vector<Camera>{cameras[c]}, mask_of(c));
    }
  }

  FeatureFrame follow(const ImageFrame& images) {
    FeatureFrame frame{.time = images.time};
    for (std::size_t c = 0; c < frontends_.size(); ++c) {
      source(c, c).add(frontends_[c].process({.time = images.time, .images = {images.images[c]}}),
                       frame);
    }
    return frame;
  }

  // Detects points in camera 0 by another front end, which tracks them into the other cameras.
  void pair(const ImageFrame& images, FeatureFrame& frame) {
    const Camera& first = cameras_->front();
    for (std::size_t c = 1; c < cameras_->size(); ++c) {
      const Camera& other = (*cameras_)[c];
      const GrayImage &a = images.images[0], &b = images.images[c];
      if (a.empty() || b.empty() || first.width != other.width || first.height != other.height) {
        continue;
      }
      Frontend both(pair_settings(), {first}, mask_of(0));
      const FeatureFrame before = both.process({.time = {}, .images = {a}});
      const FeatureFrame after = both.process({.time = kNextInstant, .images = {b}});
      add_pairs(before, after, c, frame);
    }
  }

 private:
  FrontendSettings pair_settings() const {
    FrontendSettings settings = alone_;
    settings.reject_outliers = false;  // it assumes a single lens
    return settings;
  }
  std::vector<GrayImage> mask_of(std::size_t camera) const {
    return masks_.empty() ? std::vector<GrayImage>{} : std::vector{masks_[camera]};
  }
  Source source(std::size_t camera, std::size_t number) const {
    return {.camera = static_cast<int>(camera),
            .source = static_cast<LandmarkId>(number),
            .sources = static_cast<LandmarkId>(2 * frontends_.size())};
  }
  void add_pairs(const FeatureFrame& before, const FeatureFrame& after, std::size_t camera,
                 FeatureFrame& frame) {
    FeatureFrame first, second;
    for (const PixelObservation& o : after.pixels) {
      const auto same = std::find_if(before.pixels.begin(), before.pixels.end(),
                                     [&](const auto& p) { return p.landmark == o.landmark; });
      if (same == before.pixels.end()) continue;  // detected in the second image
      first.pixels.push_back({.landmark = pairs_, .camera = 0, .pixel = same->pixel});
      second.pixels.push_back({.landmark = pairs_++, .camera = 0, .pixel = o.pixel});
    }
    const std::size_t number = frontends_.size() + camera;
    source(0, number).add(first, frame);
    source(camera, number).add(second, frame);
  }

  const std::vector<Camera>* cameras_;
  FrontendSettings alone_;  // of one camera
  std::vector<GrayImage> masks_;
  std::vector<Frontend> frontends_;
  LandmarkId pairs_ = 0;
};

}  // namespace

ImageTracks track_images(const Recording& recording, double seconds,
                         const FrontendSettings& settings) {
  ImageTracks result;
  if (recording.images->size() == 0 || recording.cameras.empty()) return result;
  const auto images = liveliest_part(recording, seconds);
  const std::size_t frames = images->size(), step = 1 + frames / kPairs;
  std::vector<GrayImage> masks = masks_of(settings.mask, recording);
  for (std::size_t c = 0; c < masks.size(); ++c) {
    if (masks[c].empty()) continue;
    result.facts.push_back(
        {fmt::format("cam{}", c), "covered by the mask", 100 * covered_share(masks[c]), "%"});
  }
  try {
    Tracker tracker(recording.cameras, settings, std::move(masks));
    Progress progress(frames, bars_are_unwanted());
    for (std::size_t i = 0; i < frames; ++i) {
      interruption_point(i, frames);
      const ImageFrame now = read(*images, i, recording.cameras.size());
      FeatureFrame frame = tracker.follow(now);
      if (i % step == 0) tracker.pair(now, frame);
      result.frames.push_back(std::move(frame));
      progress.show(i + 1);
    }
  } catch (const UsageError& error) {
    result.not_checked.push_back(fmt::format("the content of the images: {}", error.what()));
  }
  result.facts.push_back(
      {"images", "followed", static_cast<double>(result.frames.size()), "frames"});
  return result;
}

}  // namespace chasles
