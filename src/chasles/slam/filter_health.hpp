#pragma once

#include <optional>

#include <chasles/estimate/estimate.hpp>

namespace chasles {

/// Says how reliable the estimates of a filter are, by its observations and innovations.
class FilterHealth {
 public:
  /// Sets health and reason of the estimate of each frame, in the order of time. `sane_clock`: the
  /// time offset is one that pixels determine.
  void assess(Estimate& e, bool sane_clock);

 private:
  bool was_blind(Time time, bool sees);

  RecentInnovations recent_innovations_;
  int starved_ = 0;                ///< consecutive frames with almost no observation
  std::optional<Time> last_seen_;  ///< the last frame with observations, or at a standstill
  std::optional<Time> regained_;   ///< the first such frame after a second without
};

}  // namespace chasles
