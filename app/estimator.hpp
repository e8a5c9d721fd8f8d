#pragma once

#include <string>

namespace chasles::app {

/// What estimates: the filter, batch estimation, or a window of so many keyframes.
struct Estimator {
  bool batch = false;
  int window = 0;  ///< keyframes; 0: no window

  bool filter() const { return !batch && window == 0; }
};

/// "filter", "batch" or "window:N", N of 2 or more, as `option` has it. Throws UsageError.
Estimator estimator_from(const std::string& option, const std::string& text);

}  // namespace chasles::app
