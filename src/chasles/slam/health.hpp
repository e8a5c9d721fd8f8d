#pragma once

#include <deque>
#include <string>

#include <chasles/time.hpp>

namespace chasles {

/// How far an estimate is to be believed.
enum class Health {
  kOk,
  kDegraded,  ///< for a second: fewer than 3 observations used, or more refused than used
  kLost,      ///< not finite, or a covariance without meaning: nothing after this counts
};
std::string name(Health health);

/// What the frames of the last second used and refused.
class RecentUse {
 public:
  /// With this frame: degraded or ok. Times rise.
  Health judge(Time time, int used, int rejected);

 private:
  struct Use {
    Time time{};
    int used = 0, rejected = 0;
  };
  std::deque<Use> last_second_;
};

}  // namespace chasles
