#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace chasles {

/// The larger of the two middle ones of an even number. `values`: at least one, none NaN.
inline double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace chasles
