#include <condition_variable>
#include <deque>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>
#include <variant>

#include <chasles/slam/read_ahead.hpp>

namespace chasles {

struct ReadAhead::Shared {
  explicit Shared(std::function<std::optional<SensorEvent>()> next) : next_event(std::move(next)) {}

  // The other thread.
  void read() {
    std::exception_ptr thrown;
    try {
      while (has_room()) {
        auto event = next_event();
        if (!event) break;
        add(std::move(*event));
      }
    } catch (...) {
      thrown = std::current_exception();
    }
    const std::lock_guard lock(mutex);
    failure = thrown;
    ended = true;
    changed.notify_all();
  }

  // Waits for it; false when all is to stop.
  bool has_room() {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return stop || images < kImages; });
    return !stop;
  }

  void add(SensorEvent event) {
    const std::lock_guard lock(mutex);
    images += std::holds_alternative<ImageFrame>(event);
    ready.push_back(std::move(event));
    changed.notify_all();
  }

  std::optional<SensorEvent> take() {
    std::unique_lock lock(mutex);
    changed.wait(lock, [&] { return ended || !ready.empty(); });
    if (ready.empty()) {
      if (failure) std::rethrow_exception(std::exchange(failure, nullptr));
      return std::nullopt;
    }
    SensorEvent event = std::move(ready.front());
    ready.pop_front();
    images -= std::holds_alternative<ImageFrame>(event);
    changed.notify_all();
    return event;
  }

  const std::function<std::optional<SensorEvent>()> next_event;

  std::mutex mutex;
  std::condition_variable changed;
  std::deque<SensorEvent> ready;
  std::size_t images = 0;  // of those ready
  std::exception_ptr failure;
  bool ended = false, stop = false;
  std::thread reader;  // the last: it uses all above
};

ReadAhead::ReadAhead(std::function<std::optional<SensorEvent>()> next)
    : shared_(std::make_unique<Shared>(std::move(next))) {
  shared_->reader = std::thread([shared = shared_.get()] { shared->read(); });
}

ReadAhead::~ReadAhead() {
  {
    const std::lock_guard lock(shared_->mutex);
    shared_->stop = true;
    shared_->changed.notify_all();
  }
  shared_->reader.join();
}

std::optional<SensorEvent> ReadAhead::next() { return shared_->take(); }

}  // namespace chasles
