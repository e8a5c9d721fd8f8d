#pragma once

/// Lower limits of stated sigmas, because a sigma of zero has no finite weight.
namespace chasles::smooth_detail {

/// Sigmas at the start [rad, m, m/s, m/s^2], and of a gyroscope bias [rad/s].
inline constexpr double kFloor = 1e-6, kRateFloor = 1e-8;

/// A random walk, in the units of the state, per square root of a second.
inline constexpr double kLeastWalk = 1e-7;

}  // namespace chasles::smooth_detail
