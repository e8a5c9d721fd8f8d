#pragma once

/// What is stated to be exact counts as so much: a deviation of zero has no weight.
namespace chasles::smooth_detail {

/// Deviations at the start [rad, m, m/s, m/s^2], and of a gyroscope's bias [rad/s].
inline constexpr double kFloor = 1e-6, kRateFloor = 1e-8;

/// A random walk, in the units of what walks, per square root of a second.
inline constexpr double kLeastWalk = 1e-7;

}  // namespace chasles::smooth_detail
