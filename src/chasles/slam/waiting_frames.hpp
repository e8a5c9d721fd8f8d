#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <utility>

namespace chasles {

/// Frames in order of time that wait until IMU samples cover them. An estimator propagates to a
/// frame only when the samples reach its time.
template <typename Frame>
class WaitingFrames {
 public:
  void add(Frame frame) { frames_.push_back(std::move(frame)); }

  /// The oldest frame, if `covered` is true for it.
  template <typename Covered>
  std::optional<Frame> next(const Covered& covered) {
    if (frames_.empty() || !covered(frames_.front())) return std::nullopt;
    std::optional<Frame> frame(std::move(frames_.front()));
    frames_.pop_front();
    return frame;
  }
  /// The oldest frame, covered or not; no more samples come.
  std::optional<Frame> next() {
    return next([](const Frame&) { return true; });
  }

  bool empty() const { return frames_.empty(); }
  std::size_t size() const { return frames_.size(); }
  void clear() { frames_.clear(); }

 private:
  std::deque<Frame> frames_;
};

}  // namespace chasles
