#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace chasles {

/// The median; for an even number of values the larger of the two middle ones. `values`: at least
/// one, none NaN.
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace chasles
