#pragma once

#include <limits>
#include <numbers>

namespace chasles {

inline constexpr double kDegrees = 180 / std::numbers::pi;                ///< degrees per radian
inline constexpr double kRadians = std::numbers::pi / 180;                ///< radians per degree
inline constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();  ///< unknown value

}  // namespace chasles
