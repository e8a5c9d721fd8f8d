#pragma once

#include <deque>
#include <string>

#include <chasles/time.hpp>

namespace chasles {

/// The reliability of an estimate.
enum class Health {
  kOk,
  kDegraded,  ///< in the last second: fewer than 3 observations used, or more rejected than used
  kLost,  ///< not finite, or an invalid covariance: this and all later estimates are meaningless
};
std::string name(Health health);

/// Numbers of observations that were used and rejected in the last second.
class RecentUse {
 public:
  /// Adds this frame; returns degraded or ok. Times rise.
  Health judge(Time time, int used, int rejected);

 private:
  struct Use {
    Time time{};
    int used = 0, rejected = 0;
  };
  std::deque<Use> last_second_;
};

}  // namespace chasles
