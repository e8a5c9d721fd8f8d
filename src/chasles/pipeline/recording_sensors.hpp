#pragma once

#include <chasles/camera/track_noise.hpp>
#include <chasles/pipeline/estimator.hpp>
#include <chasles/recording/recording.hpp>

// The sensors of a recording, for an estimator.
namespace chasles {

/// Standard deviation of a point of this front end [px], where all of its error is taken as white.
/// It is correlated between frames, so this is larger than its scatter (docs/pixels.md).
inline constexpr double kFrontendPixelSigma = 0.4;
/// The noise of its tracks for a filter. It stands for errors of calibration, too, which many
/// tracks have in common (docs/noise.md).
inline constexpr TrackNoise kFrontendTrackNoise{.sigma = 3, .drift = 2, .match = 1};
/// The same for batch and window, which have no walk; the filter that a batch starts from has it.
inline constexpr TrackNoise kSmoothedTrackNoise{.sigma = 4, .drift = 2, .match = 1};
/// The same for rendered images, whose calibration is exact.
inline constexpr TrackNoise kRenderedTrackNoise{.sigma = 0.4, .drift = 0.3, .match = 0.1};

/// Cameras, IMU noise and ranges, and the pixel noise. Where the recording does not state the
/// latter it is kFrontendPixelSigma for images and 1 px for tracks. Throws InputError where cameras
/// or the IMU's noise are missing.
InertialSensors inertial_sensors(const Recording& recording);

/// The convention and the ranges of the recording's IMU.
ImuBuffer::Options imu_options(const Recording& recording);

/// The settings of a run on images, with what is `auto` decided:
/// - keep_scale: true with one camera (`cameras`: as cameras_in_stereo()), where pixels alone have
/// to
///   find the scale after a standstill. Not with the chart left-se3, which has no such option;
/// - calibrate_time_offset: true for the filter. Batch and window take the offset as known;
/// - track_sigma (if no pixel_sigma is stated), track_drift and match_sigma: as
///   kFrontendTrackNoise, with batch and window as kSmoothedTrackNoise, and as kRenderedTrackNoise
///   where the calibration of the cameras or the noise of the IMU is exact;
/// - batch.loss_width 1 and batch.gate 2 with kSmoothedTrackNoise;
/// - guessed_depth_observations: 20;
/// - imu_noise_scale 3 and vibration_noise 1, unless the noise of the IMU is exact.
InertialRunSettings for_images(InertialRunSettings settings, std::size_t cameras,
                               const ImuNoise& noise, bool exact_calibration = false);
/// Those of a run on the recording, images or not. A pixel noise that the recording states is kept.
/// exact_map: true for the filter. Throws UsageError for recognition by appearance without images,
/// or in a window.
InertialRunSettings decided(InertialRunSettings settings, const Recording& recording);

/// The rig, and the noise by choose_noise() (velocity/velocity_noise.hpp). Throws InputError where
/// velocities or the rig are missing.
VelocitySensors velocity_sensors(const Recording& recording, const VelocityRunSettings& settings);

/// A correction of the body velocities' clock.
struct ClockCorrection {
  double offset = 0;   ///< subtracted from the velocities' times [s]
  std::string remark;  ///< the result as a message; empty where the settings state the offset
};
/// Shifts the velocities to the frames' clock: by time_offset of the settings or, where it is
/// `auto`, by the offset that the tracks determine (check/velocity_clock.hpp), if they do.
ClockCorrection correct_clock(const VelocitySlamSettings& settings, Recording& recording);

/// The estimator of that kind of run for a recording. Throws as the functions above.
/// `start`: see make_estimator().
std::unique_ptr<Estimator> make_estimator(const InertialRunSettings& settings,
                                          const Recording& recording,
                                          std::optional<InertialStart> start = std::nullopt);
std::unique_ptr<Estimator> make_estimator(const VelocityRunSettings& settings,
                                          const Recording& recording);

}  // namespace chasles
