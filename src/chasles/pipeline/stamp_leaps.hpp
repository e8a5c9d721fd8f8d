#pragma once

#include <algorithm>
#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include <chasles/base/time.hpp>

namespace chasles {

/// Distinguishes a wrong stamp of a topic from a clock that has jumped. A stamp that leaps back or
/// ahead of those before it is held until the next message: one that leaps to the same time
/// confirms it, and without that it was wrong. `Timed` has a member `time`.
template <typename Timed>
class StampLeaps {
 public:
  /// Further back than this a message is no late one.
  static constexpr Time kBack = std::chrono::milliseconds(500);
  /// Further ahead, a topic has paused, or the stamp is wrong. A stamp confirms another one within
  /// the same time.
  static constexpr Time kAhead = std::chrono::seconds(2);

  /// What is to be taken now, in the order in which it came.
  struct Passed {
    std::vector<Timed> messages = {};
    bool jumped_back = false;  ///< the messages are the first ones after a jump of the clock
  };
  Passed add(Timed message) {
    const bool leap = leaps(message.time);
    if (held_ && leap && std::chrono::abs(message.time - held_->time) <= kAhead) {
      Passed passed{.jumped_back = held_->time < *newest_};
      newest_ = std::max(held_->time, message.time);
      passed.messages.push_back(std::move(*held_));
      passed.messages.push_back(std::move(message));
      held_.reset();
      return passed;
    }
    if (held_) ++wrong_;
    held_.reset();
    if (leap) {
      held_ = std::move(message);
      return {};
    }
    newest_ = std::max(newest_.value_or(message.time), message.time);
    Passed passed;
    passed.messages.push_back(std::move(message));
    return passed;
  }

  /// Nothing more comes: a message that leapt ahead may have been after a pause.
  std::optional<Timed> finish() {
    if (held_ && held_->time < *newest_) held_.reset();
    return std::exchange(held_, std::nullopt);
  }

  int wrong() const { return wrong_; }  ///< messages that were left out

 private:
  bool leaps(Time time) const {
    return newest_ && (time + kBack < *newest_ || time > *newest_ + kAhead);
  }

  std::optional<Time> newest_;
  std::optional<Timed> held_;
  int wrong_ = 0;
};

}  // namespace chasles
