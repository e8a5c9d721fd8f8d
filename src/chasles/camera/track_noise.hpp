#pragma once

namespace chasles {

/// The error of the pixels of a track: white noise, and a random walk of the observed point across
/// its ray. A patch that is followed slides over its surface as the view changes, so the errors of
/// successive observations are alike (docs/noise.md). All cameras that observe the point share its
/// walk, because one camera's patch is matched in the others.
struct TrackNoise {
  double sigma = 0;  ///< white, of each coordinate [px]
  double drift = 0;  ///< density of the walk of each coordinate [px/sqrt(s)]

  /// Variance of the walk over a time [s], in each coordinate [px^2].
  double drift_variance(double seconds) const { return drift * drift * seconds; }
};

}  // namespace chasles
