#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include <chasles/slam/feature_feed.hpp>

namespace chasles {

struct FeatureFeed::Shared {
  Shared(std::function<std::optional<SensorEvent>()> next, const FrontendSettings& settings,
         std::vector<Camera> cameras, const ImuBuffer::Options& options,
         std::vector<GrayImage> masks)
      : next_event(std::move(next)),
        tracker(settings, std::move(cameras), options, std::move(masks)),
        learnt(kLead, Eigen::Vector3d::Zero()) {}

  // What one event becomes; none at the end, or when all is to stop.
  std::optional<Item> make() {
    std::optional<SensorEvent> event = next_event();
    if (!event) return std::nullopt;
    if (auto* sample = std::get_if<ImuSample>(&*event)) {
      tracker.process(*sample);
      return *sample;
    }
    if (auto* frame = std::get_if<FeatureFrame>(&*event)) return std::move(*frame);
    const auto bias = next_bias();
    if (!bias) return std::nullopt;
    return tracker.process(std::get<ImageFrame>(*event), *bias);
  }

  // The bias that counts for the next image; waits for it. None when all is to stop.
  std::optional<Eigen::Vector3d> next_bias() {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return stop || !learnt.empty(); });
    if (stop) return std::nullopt;
    const Eigen::Vector3d bias = learnt.front();
    learnt.pop_front();
    return bias;
  }

  // The other thread: makes items until the end.
  void work_ahead() {
    try {
      while (auto item = make()) {
        const std::lock_guard lock(mutex);
        if (stop) break;
        ready.push_back(std::move(*item));
        changed.notify_all();
      }
    } catch (...) {
      failure = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    ended = true;
    changed.notify_all();
  }

  std::optional<Item> take() {
    std::optional<Item> item;
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return ended || !ready.empty(); });
    if (!ready.empty()) {
      item.emplace(std::move(ready.front()));
      ready.pop_front();
    } else if (failure) {
      std::rethrow_exception(std::exchange(failure, nullptr));
    }
    return item;
  }

  std::function<std::optional<SensorEvent>()> next_event;
  ImageTracker tracker;

  std::mutex mutex;
  std::condition_variable changed;
  std::deque<Eigen::Vector3d> learnt;  // of images to come
  std::deque<Item> ready;
  std::exception_ptr failure;
  bool ended = false, stop = false;
  std::thread worker;  // the last: it uses all above
};

FeatureFeed::FeatureFeed(std::function<std::optional<SensorEvent>()> next,
                         const FrontendSettings& settings, std::vector<Camera> cameras,
                         const ImuBuffer::Options& imu, bool ahead, std::vector<GrayImage> masks)
    : shared_(std::make_unique<Shared>(std::move(next), settings, std::move(cameras), imu,
                                       std::move(masks))) {
  if (ahead) shared_->worker = std::thread([shared = shared_.get()] { shared->work_ahead(); });
}

FeatureFeed::~FeatureFeed() {
  if (!shared_->worker.joinable()) return;
  {
    const std::lock_guard lock(shared_->mutex);
    shared_->stop = true;
    shared_->changed.notify_all();
  }
  shared_->worker.join();
}

std::optional<FeatureFeed::Item> FeatureFeed::next() {
  return shared_->worker.joinable() ? shared_->take() : shared_->make();
}

void FeatureFeed::learnt(const Eigen::Vector3d& gyroscope_bias) {
  const std::lock_guard lock(shared_->mutex);
  shared_->learnt.push_back(gyroscope_bias);
  shared_->changed.notify_all();
}

}  // namespace chasles
