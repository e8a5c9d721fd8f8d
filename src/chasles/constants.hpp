#pragma once

#include <limits>
#include <numbers>

namespace chasles {

inline constexpr double kDegrees = 180 / std::numbers::pi;                ///< of a radian
inline constexpr double kRadians = std::numbers::pi / 180;                ///< of a degree
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();  ///< not known

}  // namespace chasles
