#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>

#include <chasles/slam/feature_feed.hpp>

namespace chasles {

/// Events read on a thread of their own before they are asked for: to decode an image may take
/// longer than all that is done with it. The same events in the same order.
class ReadAhead {
 public:
  /// So many images wait at most.
  static constexpr std::size_t kImages = 4;

  /// `next` gives the events, none at the end. What it throws is thrown by next() below, after the
  /// events before it.
  explicit ReadAhead(std::function<std::optional<SensorEvent>()> next);
  ~ReadAhead();

  /// Waits for it; none at the end.
  std::optional<SensorEvent> next();

 private:
  struct Shared;
  std::unique_ptr<Shared> shared_;
};

}  // namespace chasles
