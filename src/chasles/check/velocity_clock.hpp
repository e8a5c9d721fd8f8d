#pragma once

#include <optional>

#include <chasles/recording/recording.hpp>

/// The time offset of the body velocities relative to the frames, determined from the tracks. A
/// GNSS/INS filters its velocities and stamps them on output: KITTI's are late by half a sample and
/// more.
namespace chasles {

/// The estimated time offset and its accuracy.
struct VelocityClock {
  double offset = 0;   ///< frames' clock + offset = velocities' clock [s]; above 0: stamped late
  double sigma = 0;    ///< standard deviation of the offset; seconds are treated as independent [s]
  double scatter = 0;  ///< robust sigma of a pixel's difference from the velocities' prediction,
                       ///< less the part that its disparity explains [px]
  double sample_noise = 0;  ///< effect of the samples' white noise on such a pixel [px]

  /// Smaller offsets are not reported [s].
  static constexpr double kLeastOffset = 0.01;
  /// Whether the offset is reliable despite the samples' noise. The mean of two noisy samples has
  /// less noise than either, which biases an offset away from the samples' own instants. If the
  /// noise is too large, offset and sigma stay 0.
  bool is_determined() const;
  /// Whether it is also larger than three sigmas and than kLeastOffset.
  bool stands_out() const;
};

/// Compares the image motion of the landmarks of a rectified pair over 0.4 s with the motion that
/// the velocities predict, shifted by an offset. The fit also estimates a constant rotation, scale
/// and bias, by robust least squares. Returns nothing for fewer than ten seconds of tracks, an
/// offset beyond 0.3 s, or a motion that does not change.
std::optional<VelocityClock> velocity_clock(const Recording& recording);

/// Moves the stamps of the velocities to the frames' clock. Samples that then precede the first
/// frame become one interpolated sample at that frame, so that a run starts where it did.
void shift_velocities(Recording& recording, double offset);

}  // namespace chasles
