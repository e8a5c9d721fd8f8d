#pragma once

#include <cstddef>
#include <optional>
#include <string>

namespace chasles {

/// How many frames of a recording a run estimated.
struct FrameCoverage {
  /// Frames with an estimate that is not lost. A window or batch with fewer keyframes than frames
  /// estimates the frames between them too.
  std::size_t estimated = 0;
  /// Frames in the part that was asked for; of an interrupted run, those before the interruption.
  std::size_t frames = 0;
  std::size_t before_start = 0;  ///< frames before the first estimate

  double share() const;  ///< from 0 to 1; 0 without frames
};

/// A run that estimated a smaller share is not healthy.
inline constexpr double kLeastCoverage = 0.5;

/// What else is known of a run with a small coverage.
struct CoverageCauses {
  std::optional<double> start_seconds;  ///< from the first frame to the first estimate [s]
  int resets = 0, dropped_frames = 0;
};

/// Says how many frames were estimated, and the likely cause; empty for a sufficient coverage.
std::string coverage_remark(const FrameCoverage& coverage, const CoverageCauses& causes);

}  // namespace chasles
