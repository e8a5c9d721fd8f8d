#pragma once

#include <optional>

#include <chasles/data/recording.hpp>

/// How the clock of body velocities stands against that of the frames. A GNSS/INS filters its
/// velocities and stamps them when it sends them: KITTI's are late by half a sample and more.
namespace chasles {

/// What the tracks tell of it.
struct VelocityClock {
  double offset = 0;   ///< frames' clock + offset = velocities' clock [s]; above 0: stamped late
  double sigma = 0;    ///< its standard deviation, from seconds that are taken as independent [s]
  double scatter = 0;  ///< robust deviation of a pixel from what the velocities predict, less what
                       ///< its disparity explains [px]
  double sample_noise = 0;  ///< what the samples' own white noise moves such a pixel by [px]

  /// Smaller offsets are of no matter [s].
  static constexpr double kLeastOffset = 0.01;
  /// The samples' noise does not hide it. Between two noisy samples their mean is less noisy than
  /// either, which draws an offset away from the samples' own instants; offset and sigma are then
  /// left at 0.
  bool believable() const;
  /// And it is more than three deviations, and matters.
  bool stands_out() const;
};

/// From where the landmarks of a rectified pair go in the image within 0.4 s, against where the
/// velocities take them, shifted by an offset (and turned, scaled and freed of a bias by what is
/// constant over the recording): robust least squares. None where there is too little to tell it
/// from: fewer than ten seconds of tracks, an offset beyond 0.3 s, or motion that does not change.
std::optional<VelocityClock> velocity_clock(const Recording& recording);

/// The velocities with the stamps of the frames' clock. What that moves before the first frame
/// becomes one sample at it, between its neighbours: a run begins where it did.
void shift_velocities(Recording& recording, double offset);

}  // namespace chasles
