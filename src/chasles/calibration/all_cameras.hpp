#pragma once

#include <cstddef>
#include <limits>

namespace chasles {

/// Where a function takes the first so many cameras: all of them.
inline constexpr std::size_t kAllCameras = std::numeric_limits<std::size_t>::max();

}  // namespace chasles
