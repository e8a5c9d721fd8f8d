#include <condition_variable>
#include <mutex>
#include <utility>

#include <chasles/base/error.hpp>
#include <chasles/pipeline/ahead.hpp>
#include <chasles/pipeline/feature_feed.hpp>

namespace chasles {

struct FeatureFeed::Shared {
  Shared(std::function<std::optional<SensorEvent>()> next, const FrontendSettings& settings,
         std::vector<Camera> cameras, const ImuBuffer::Options& options,
         std::vector<GrayImage> masks)
      : next_event(std::move(next)) {
    if (!cameras.empty()) tracker.emplace(settings, std::move(cameras), options, std::move(masks));
  }

  // The item for one event; none at the end, or when the feed stops.
  std::optional<Item> make() {
    std::optional<SensorEvent> event = next_event();
    if (!event) return std::nullopt;
    return std::visit(Overloaded{[&](ImageFrame&& images) { return track(std::move(images)); },
                                 [&](ImuSample&& sample) {
                                   if (tracker) tracker->process(sample);
                                   return std::optional<Item>(sample);
                                 },
                                 [](auto&& other) {
                                   return std::optional<Item>(std::forward<decltype(other)>(other));
                                 }},
                      std::move(*event));
  }

  std::optional<Item> track(ImageFrame&& images) {
    if (!tracker) throw InputError("images need cameras: the recording has none");
    const auto bias = next_bias();
    if (!bias) return std::nullopt;
    return tracker->process(std::make_shared<const ImageFrame>(std::move(images)), *bias);
  }

  // The bias for the next image; waits for it. None when the feed stops.
  std::optional<Eigen::Vector3d> next_bias() {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return stop || biases.known(); });
    if (stop) return std::nullopt;
    const Eigen::Vector3d bias = biases.next();
    biases.pass();
    return bias;
  }

  std::function<std::optional<SensorEvent>()> next_event;
  std::optional<ImageTracker> tracker;  // none without cameras

  std::mutex mutex;
  std::condition_variable changed;
  DelayedBias biases;
  bool stop = false;
  std::optional<Ahead<Item>> ahead;  // last, because it uses all members above
};

FeatureFeed::FeatureFeed(std::function<std::optional<SensorEvent>()> next,
                         const FrontendSettings& settings, std::vector<Camera> cameras,
                         const ImuBuffer::Options& imu, bool ahead, std::vector<GrayImage> masks)
    : shared_(std::make_unique<Shared>(std::move(next), settings, std::move(cameras), imu,
                                       std::move(masks))) {
  if (!ahead) return;
  const auto counted = [](const Item& item) { return is_frame(item); };
  shared_->ahead.emplace([shared = shared_.get()] { return shared->make(); }, counted, kLead);
}

FeatureFeed::~FeatureFeed() {
  const std::lock_guard lock(shared_->mutex);
  shared_->stop = true;
  shared_->changed.notify_all();
}

std::optional<FeatureFeed::Item> FeatureFeed::next() {
  return shared_->ahead ? shared_->ahead->next() : shared_->make();
}

void FeatureFeed::note_bias(const Eigen::Vector3d& gyroscope_bias) {
  const std::lock_guard lock(shared_->mutex);
  shared_->biases.note(gyroscope_bias);
  shared_->changed.notify_all();
}

}  // namespace chasles
