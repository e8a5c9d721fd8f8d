#pragma once

#include <chasles/base/constants.hpp>

// What a finding on a truth takes (docs/evaluation.md). The examination decides by these, and the
// sentences state them.
namespace chasles::truth_limits {

inline constexpr double kManySigmas = 5;          ///< of an offset or an angle
inline constexpr double kLeastOffset = 0.002;     ///< [s]
inline constexpr double kMostOffsetSigma = 0.05;  ///< [s]
inline constexpr double kLeastOffsetWithoutPositions = 0.005;
inline constexpr double kUnlike = 0.8;       ///< of the rates, unexplained
inline constexpr double kUnlikePath = 0.85;  ///< of the extent, that the best similarity leaves
inline constexpr double kOtherAxes = 6 * kRadians;
inline constexpr double kTurnSigmas = 8;
/// Between axes that are called the same: an angle that is certain and matters counts from here.
inline constexpr double kLeastTurn = 1 * kRadians, kLeastTurnOfGyroscope = 3 * kRadians;
inline constexpr double kTurnByPositions = 20 * kRadians;
inline constexpr double kLeastPoint = 0.02;  ///< [m]
inline constexpr double kPointSigmas = 8;
inline constexpr double kMirrorGain = 0.2;  ///< of the rms, that a reflection leaves
inline constexpr double kTilt = 5 * kRadians, kTiltOfUnknown = 20 * kRadians;
inline constexpr double kInterpolationShare = 0.3;  ///< of an error, that interpolation may have

}  // namespace chasles::truth_limits
