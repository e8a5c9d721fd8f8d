#pragma once

#include <array>
#include <optional>
#include <span>

#include <chasles/calibrate/noise/even_samples.hpp>

namespace chasles {

/// The density of a signal at frequencies that a motion hardly has.
struct MotionNoise {
  double density = 0;         ///< root of the mean power [unit/sqrt(Hz)]: with vibration
  double relative_sigma = 0;  ///< of the density, from the scatter of the windows
  /// That which the tenth of white noise's windows would have below the quietest tenth of these, at
  /// most `density`: the sensor's own noise is at most that, unless the sensor filters its samples.
  double quietest = 0;
};

/// What is between 0.2 and 0.3 of the rate, where white noise has its full density and a digital
/// low-pass of a sensor begins. Vibration is there too, so it is an upper limit.
struct MotionBand {
  double seconds = 0;              ///< of all windows
  double lowest = 0, highest = 0;  ///< [Hz]
  std::array<MotionNoise, kImuSignals> signals;
};

/// Periodograms of windows of one second with Hann's taper. Nothing from fewer than five windows,
/// and from rates below 64 Hz, at which a motion has these frequencies.
std::optional<MotionBand> motion_noise(std::span<const EvenSpan> spans);

}  // namespace chasles
