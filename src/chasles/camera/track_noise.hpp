#pragma once

namespace chasles {

/// The error of the pixels of a track (docs/noise.md):
/// - white noise;
/// - a random walk of the observed point across its ray. A patch that is followed slides over its
///   surface as the view changes, so the errors of successive observations are alike. All cameras
///   that observe the point share the walk, because the patch of the camera that found the track is
///   matched in the others;
/// - a constant error of the matches (PixelObservation::is_match()) in each other camera.
struct TrackNoise {
  double sigma = 0;  ///< white, of each coordinate [px]
  double drift = 0;  ///< density of the walk of each coordinate [px/sqrt(s)]
  double match = 0;  ///< constant along a track, in cameras that did not find it [px]

  bool is_white() const { return drift <= 0 && match <= 0; }

  /// Variance of the walk over a time [s], in each coordinate [px^2].
  double drift_variance(double seconds) const { return drift * drift * seconds; }

  /// Added to the variance of the n-th match of a point, counted from 1 [px^2]. Since the sum of
  /// 1 / (n (n + 1)) is 1, all matches together have at most the information of one, 1 / match^2.
  double match_variance(int n) const { return match * match * n * (n + 1); }
};

}  // namespace chasles
