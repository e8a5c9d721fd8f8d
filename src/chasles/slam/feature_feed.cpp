#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include <chasles/lie/so3.hpp>
#include <chasles/slam/feature_feed.hpp>

namespace chasles {
namespace {

// From the IMU's axes at one time to those at a later one.
RotationPrior rotation_between(ImuBuffer& imu, Time from, Time to, const Eigen::Vector3d& bias) {
  const std::vector<ImuInterval> intervals = imu.between(from, to);
  RotationPrior prior;
  bool measured = !intervals.empty();
  for (const ImuInterval& interval : intervals) {
    measured = measured && interval.gyroscope_extra_density == 0;  // not saturated
    prior.now_R_last_imu =
        so3::exp(-(interval.angular_rate_imu - bias) * interval.tau) * prior.now_R_last_imu;
  }
  prior.now_R_last_imu = so3::normalized(prior.now_R_last_imu);
  if (!prior.now_R_last_imu.allFinite()) return {};  // absurd rates
  prior.trusted = measured;
  return prior;
}

}  // namespace

struct FeatureFeed::Shared {
  Shared(std::function<std::optional<SensorEvent>()> next, const FrontendSettings& settings,
         std::vector<Camera> cameras, const ImuBuffer::Options& options,
         std::vector<GrayImage> masks)
      : next_event(std::move(next)),
        frontend(settings, std::move(cameras), std::move(masks)),
        imu(options),
        learnt(kLead, Eigen::Vector3d::Zero()) {}

  // What one event becomes; none at the end, or when all is to stop.
  std::optional<Item> make() {
    std::optional<SensorEvent> event = next_event();
    if (!event) return std::nullopt;
    if (auto* sample = std::get_if<ImuSample>(&*event)) {
      imu.add(*sample);
      return *sample;
    }
    if (auto* frame = std::get_if<FeatureFrame>(&*event)) return std::move(*frame);
    const auto bias = next_bias();
    if (!bias) return std::nullopt;
    return track(std::get<ImageFrame>(*event), *bias);
  }

  TrackedFrame track(const ImageFrame& images_now, const Eigen::Vector3d& bias) {
    const auto started = std::chrono::steady_clock::now();
    TrackedFrame result;
    result.frame.time = images_now.time;
    if (last && images_now.time <= *last) return result;
    RotationPrior prior;
    if (last) prior = rotation_between(imu, *last, images_now.time, bias);
    last = images_now.time;
    imu.forget_before(images_now.time);
    result.frame = frontend.process(images_now, prior);
    result.report = frontend.report();
    result.seconds =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
    return result;
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
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return ended || !ready.empty(); });
    if (ready.empty()) {
      if (failure) std::rethrow_exception(std::exchange(failure, nullptr));
      return std::nullopt;
    }
    Item item = std::move(ready.front());
    ready.pop_front();
    return item;
  }

  std::function<std::optional<SensorEvent>()> next_event;
  Frontend frontend;
  ImuBuffer imu;
  std::optional<Time> last;

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
