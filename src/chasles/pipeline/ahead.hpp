#pragma once

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace chasles {

/// Makes items in advance on a thread of its own: the same items in the same order.
template <typename T>
class Ahead {
 public:
  /// `make` returns the items, none at the end. Its exceptions are rethrown by next(), after the
  /// items before them. At most `most` of the items for which `counted` is true wait to be taken.
  Ahead(std::function<std::optional<T>()> make, std::function<bool(const T&)> counted,
        std::size_t most)
      : make_(std::move(make)), counted_(std::move(counted)), most_(most) {
    worker_ = std::thread([this] { work(); });
  }
  Ahead(const Ahead&) = delete;
  Ahead& operator=(const Ahead&) = delete;

  /// Waits for the item that is being made.
  ~Ahead() {
    {
      const std::lock_guard lock(mutex_);
      stop_ = true;
      changed_.notify_all();
    }
    worker_.join();
  }

  /// Waits for the next item; none at the end.
  std::optional<T> next() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return ended_ || !ready_.empty(); });
    if (ready_.empty()) {
      if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
      return std::nullopt;
    }
    std::optional<T> item(std::move(ready_.front()));
    ready_.pop_front();
    waiting_ -= counted_(*item);
    changed_.notify_all();
    return item;
  }

 private:
  // Runs on the other thread.
  void work() {
    std::exception_ptr thrown;
    try {
      while (has_room()) {
        std::optional<T> item = make_();
        if (!item) break;
        add(std::move(*item));
      }
    } catch (...) {
      thrown = std::current_exception();
    }
    const std::lock_guard lock(mutex_);
    failure_ = thrown;
    ended_ = true;
    changed_.notify_all();
  }

  // Waits for room; false: stop.
  bool has_room() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [&] { return stop_ || waiting_ < most_; });
    return !stop_;
  }

  void add(T item) {
    const std::lock_guard lock(mutex_);
    waiting_ += counted_(item);
    ready_.push_back(std::move(item));
    changed_.notify_all();
  }

  const std::function<std::optional<T>()> make_;
  const std::function<bool(const T&)> counted_;
  const std::size_t most_;

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<T> ready_;
  std::size_t waiting_ = 0;  // those of `ready_` that are counted
  std::exception_ptr failure_;
  bool ended_ = false, stop_ = false;
  std::thread worker_;  // last, because it uses all members above
};

}  // namespace chasles
