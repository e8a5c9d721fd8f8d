#pragma once

#include <iterator>
#include <map>

#include <chasles/time.hpp>

namespace chasles::app {

/// What the front end took for each frame, by the cameras' clock.
class FrontendSeconds {
 public:
  void add(Time time, double seconds) { all_.emplace(time, seconds); }
  /// Of the frame nearest to a time: an estimate's is of the IMU's clock.
  double at(Time time) const {
    auto found = all_.lower_bound(time);
    if (found == all_.end()) return all_.empty() ? 0 : all_.rbegin()->second;
    const bool before =
        found != all_.begin() && time - std::prev(found)->first < found->first - time;
    return before ? std::prev(found)->second : found->second;
  }

 private:
  std::map<Time, double> all_;
};

}  // namespace chasles::app
