#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include <chasles/calibrate/noise/motion_noise.hpp>
#include <chasles/calibrate/noise/noise_fit.hpp>
#include <chasles/recording/recording.hpp>

namespace chasles {

/// A point of the Allan deviation.
struct AllanPoint {
  double seconds = 0;              ///< tau
  double deviation = 0;            ///< overlapping [unit]
  double lowest = 0, highest = 0;  ///< 95 % interval, for Gaussian noise of the fit
  double dof = 0;                  ///< equivalent degrees of freedom, of the fit
  std::size_t differences = 0;
  double of_fit = 0;  ///< the deviation of the fit [unit]
};

/// A signal of a standstill.
struct StandstillSignal {
  NoiseFit fit;
  std::vector<AllanPoint> allan;
  double mean = 0;          ///< [unit]
  double sample_sigma = 0;  ///< standard deviation of a sample [unit]
  double resolution = 0;    ///< the smallest difference between two samples [unit]
};

/// Seconds since the first sample of the recording.
struct StandstillTimes {
  double begin = 0, end = 0;
};

/// N, or K, as a filter takes it for the three axes of a sensor.
struct TakenNoise {
  double value = 0;       ///< root mean square of the axes
  bool is_limit = false;  ///< of at least one axis only the limit is known
};

/// The noise of an IMU, from its samples. Signals: specific force x, y, z [m/s^2], angular rate x,
/// y, z [rad/s], in IMU axes. Densities are two-sided and in continuous time (NoisePower).
struct NoiseCalibration {
  std::string recording;
  double seconds = 0;  ///< from the first to the last sample
  double rate = 0;     ///< [Hz]
  std::size_t samples = 0;
  std::size_t interpolated = 0, left_out = 0, gaps = 0;
  std::vector<StandstillTimes> standstills;
  std::optional<std::array<StandstillSignal, kImuSignals>> standstill;
  std::optional<MotionBand> motion;
  std::optional<ImuNoise> stated;  ///< by the recording
  std::vector<std::string> remarks;

  double standstill_seconds() const;
  /// `first`: 0 for the accelerometer, 3 for the gyroscope. From a standstill, else the quietest of
  /// a motion, which is a limit.
  TakenNoise density(std::size_t first) const;
  /// From a standstill; nothing without one: no motion shows it. K of the fit without B.
  std::optional<TakenNoise> walk(std::size_t first) const;
};

struct NoiseCalibrationSettings {
  std::optional<double> start = {}, stop = {};  ///< seconds since the first event
  bool all_standstill = false;  ///< all of it is a standstill, however much it scatters
};

/// Measures the noise of a recording's IMU. Standstill: overlapping Allan deviations, and the most
/// likely N, B and K of each axis (fit_noise()). In motion: the density at high frequencies
/// (motion_noise()). Standstills are found, and count if they have five seconds in all.
///
/// Throws InputError: without an IMU; for a standstill and a motion that are both too short; for
/// stamps that are not even (2 % of the intervals); for samples at the edge of the sensor's range
/// at a standstill; for an axis that shows one number. Throws UsageError if start and stop leave
/// nothing.
NoiseCalibration calibrate_noise(const Recording& recording,
                                 const NoiseCalibrationSettings& settings = {});

}  // namespace chasles
