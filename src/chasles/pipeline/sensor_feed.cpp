#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <chasles/camera/rig_overlap.hpp>
#include <chasles/pipeline/sensor_feed.hpp>

namespace chasles {
namespace {

// Decoding an image may take longer than processing it: at most so many wait.
constexpr std::size_t kImagesReadAhead = 4;
// So many frames in which no camera that finds tracks has an image that can be read, and none
// before that has: it is not the disk, but the kind of the images.
constexpr int kFramesToGiveUp = 20;

}  // namespace

SensorFeed::SensorFeed(const Recording& recording, const FrontendSettings& frontend,
                       const ImuBuffer::Options& imu, std::vector<GrayImage> masks,
                       const SensorFeedOptions& options)
    : recording_(&recording),
      stream_(recording),
      finders_(are_finders(recording.cameras)),
      see_(options.see),
      unreadable_image_(options.unreadable) {
  std::function<std::optional<SensorEvent>()> next = [this] { return next_event(); };
  const bool images = recording.images != nullptr;
  if (options.realtime) {  // reads on its own thread
    playback_.emplace(std::move(next), PlaybackOptions{.begin = first_event(recording),
                                                       .speed = *options.realtime,
                                                       .stop = options.stop});
    next = [this] { return playback_->next(); };
  } else if (images && options.threads > 2) {
    const auto counted = [](const SensorEvent& event) { return is_frame(event); };
    ahead_.emplace(std::move(next), counted, kImagesReadAhead);
    next = [this] { return ahead_->next(); };
  }
  feed_.emplace(std::move(next), frontend, recording.cameras, imu, images && options.threads > 1,
                std::move(masks));
}

std::optional<double> SensorFeed::seconds_since(Time recorded) const {
  if (!playback_) return std::nullopt;
  return playback_->seconds_since(recorded);
}

// The front end's thread may be waiting for the playback.
void SensorFeed::close() {
  if (playback_) playback_->stop();
  feed_.reset();
  ahead_.reset();
  if (playback_) counts_ = playback_->counts();
  playback_.reset();
}

std::optional<SensorEvent> SensorFeed::next_event() {
  std::optional<Event> event = stream_.next();
  if (!event) return std::nullopt;
  return std::visit(
      Overloaded{[&](ImagesDue&& due) { return SensorEvent(read(due)); },
                 [](auto&& other) { return SensorEvent(std::forward<decltype(other)>(other)); }},
      std::move(*event));
}

ImageFrame SensorFeed::read(const ImagesDue& due) {
  const std::size_t cameras = recording_->cameras.size();
  std::optional<InputError> first;  // of the frame
  const auto damaged = [&](const InputError& error) {
    if (!first) first = error;
  };
  ImageFrame frame{.time = due.time, .images = std::vector<GrayImage>(cameras)};
  try {
    frame = recording_->images->read_undamaged(due.index, cameras, damaged);
  } catch (const InputError& error) {
    damaged(error);
  }
  if (first) ++unreadable_;
  if (shows_tracks(frame)) {
    any_read_ = true;
    see_(frame);
  } else if (first) {
    if (without_++ == 0) first_error_ = first->what();
    give_up_if_hopeless();
  }
  if (first) unreadable_image_(*first);
  return frame;
}

bool SensorFeed::shows_tracks(const ImageFrame& frame) const {
  for (std::size_t c = 0; c < std::min(frame.images.size(), finders_.size()); ++c) {
    if (finders_[c] && !frame.images[c].empty()) return true;
  }
  return false;
}

void SensorFeed::give_up_if_hopeless() const {
  const std::size_t all = recording_->images->size();
  const bool last = static_cast<std::size_t>(without_) == all;
  if (any_read_ || !(last || without_ >= kFramesToGiveUp)) return;
  throw InputError(fmt::format("none of {}{} frames of images can be read; the first: {}",
                               last ? "" : fmt::format("the first {} of ", without_), all,
                               first_error_));
}

}  // namespace chasles
