#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include <chasles/pipeline/playback.hpp>

namespace chasles {
namespace {

// The longest delay before a stop is noticed.
constexpr Time kPatience = std::chrono::milliseconds(20);

Time time_of(const SensorEvent& event) {
  return std::visit([](const auto& e) { return e.time; }, event);
}

}  // namespace

PlaybackClock wall_clock() {
  return {.now = [] { return Time(std::chrono::steady_clock::now().time_since_epoch()); },
          .wait_for = [](Time duration) { std::this_thread::sleep_for(duration); }};
}

struct Playback::Shared {
  Shared(std::function<std::optional<SensorEvent>()> next, PlaybackOptions o)
      : next_event(std::move(next)), options(std::move(o)), started(options.clock.now()) {}

  Time due(Time recorded) const {
    return started + from_seconds(to_seconds(recorded - options.begin) / options.speed);
  }

  // Runs on the other thread.
  void play() {
    try {
      while (auto event = next_event()) {
        if (!wait_until(due(time_of(*event)))) break;
        offer(std::move(*event));
      }
    } catch (...) {
      failure = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    ended = true;
    changed.notify_all();
  }

  // False: stop.
  bool wait_until(Time instant) {
    while (!asked_to_stop()) {
      const Time left = instant - options.clock.now();
      if (left <= Time(0)) return true;
      options.clock.wait_for(std::min(left, kPatience));
    }
    return false;
  }

  bool asked_to_stop() {
    if (options.stop()) stop();
    const std::lock_guard lock(mutex);
    return stopped;
  }

  void offer(SensorEvent event) {
    const bool counted = is_frame(event);
    const std::lock_guard lock(mutex);
    if (stopped) return;
    counts.came += counted;
    if (counted && frames_ready == options.waiting) {
      ++counts.dropped;
      return;
    }
    frames_ready += counted;
    ready.push_back(std::move(event));
    changed.notify_all();
  }

  std::optional<SensorEvent> take() {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return ended || stopped || !ready.empty(); });
    if (ready.empty()) {
      if (failure && !stopped) std::rethrow_exception(std::exchange(failure, nullptr));
      return std::nullopt;
    }
    SensorEvent event = std::move(ready.front());
    ready.pop_front();
    if (is_frame(event)) {
      --frames_ready;
      ++counts.taken;
    }
    return event;
  }

  void stop() {
    const std::lock_guard lock(mutex);
    stopped = true;
    counts.dropped += std::exchange(frames_ready, 0);
    ready.clear();
    changed.notify_all();
  }

  const std::function<std::optional<SensorEvent>()> next_event;
  const PlaybackOptions options;
  const Time started;

  mutable std::mutex mutex;
  std::condition_variable changed;
  std::deque<SensorEvent> ready;
  std::size_t frames_ready = 0;
  Counts counts;
  std::exception_ptr failure;
  bool ended = false, stopped = false;
  std::thread player;  // last, because it uses all members above
};

Playback::Playback(std::function<std::optional<SensorEvent>()> next, PlaybackOptions options)
    : shared_(std::make_unique<Shared>(std::move(next), std::move(options))) {
  shared_->player = std::thread([shared = shared_.get()] { shared->play(); });
}

Playback::~Playback() {
  shared_->stop();
  shared_->player.join();
}

std::optional<SensorEvent> Playback::next() { return shared_->take(); }

void Playback::stop() { shared_->stop(); }

double Playback::seconds_since(Time recorded) const {
  return to_seconds(shared_->options.clock.now() - shared_->due(recorded));
}

Playback::Counts Playback::counts() const {
  const std::lock_guard lock(shared_->mutex);
  return shared_->counts;
}

}  // namespace chasles
