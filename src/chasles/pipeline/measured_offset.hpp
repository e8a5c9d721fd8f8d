#pragma once

#include <optional>
#include <string>
#include <vector>

#include <chasles/check/camera_clock.hpp>
#include <chasles/check/other_axes.hpp>
#include <chasles/pipeline/run_settings.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/smooth/batch/batch.hpp>

// What the tracks of a recording show of its first camera, before a run.
namespace chasles {

/// Length of the images that are tracked for it [s].
inline constexpr double kExaminedSeconds = 10;

/// Tracks of the first camera, in the part of at most `seconds` [s] with the most rotation, and
/// without the gyroscope: they do not depend on the clocks. Nothing where the images cannot be
/// tracked, or where `stop`, polled for each image, returns true. Of recorded tracks: the
/// recording's own. Throws as read_masks().
std::vector<FeatureFrame> tracks_of_first_camera(const Recording& recording,
                                                 const FrontendSettings& settings, double seconds,
                                                 const StopRequest& stop = {});

/// The rotation and the epipolar lines of tracks, compared with the gyroscope and the calibration.
struct TracksEvidence {
  std::optional<CameraClock> clock = {};  ///< the time offset, if they determine it
  std::optional<LensGuess> mistake = {};  ///< in the stated lens (fit_camera())
  /// The readout of a rolling shutter of which the recording says nothing, from the first row to
  /// the last [s]; then the time offset is that of the first line.
  std::optional<Measured> readout = {};
  /// Of the samples, if not the stated ones; a run takes those that agree with gravity.
  std::optional<OtherAxes> axes = {}, taken = {};

  bool clock_stands_out() const { return clock && clock->stands_out(); }
  bool has_wrong_lens() const { return mistake.has_value(); }
};

/// What a fit of the first of the cameras to these samples means for a run with these settings.
TracksEvidence evidence_of(const CameraFit& fit, const std::vector<Camera>& cameras,
                           const std::vector<ImuSample>& imu, const InertialRunSettings& settings);

/// Examines the first camera. Nothing without an IMU or cameras, nor for recorded tracks, unless
/// the run estimates their time offset from `auto`. Throws as read_masks().
TracksEvidence examine_tracks(const Recording& recording, const InertialRunSettings& settings,
                              const StopRequest& stop = {});

/// Decides time_offset and readout_time where they are `auto`. A run starts from an offset that
/// stands out: time_offset and initial_time_offset_sigma are what was measured, and a filter of
/// which calibrate_time_offset is `auto` estimates the offset. Otherwise time_offset is 0, as in a
/// live run. readout_time is what was measured, if it was, and a filter of which
/// calibrate_readout is `auto` estimates it.
void start_from_measured(InertialRunSettings& settings, const TracksEvidence& evidence);

/// The recording as a run takes it: with its samples in the stated axes, and with readout_time.
void mend(Recording& recording, const InertialSlamSettings& settings,
          const TracksEvidence& evidence);

/// What a run says of the evidence; `settings` as they were given.
std::vector<std::string> remarks_of(const TracksEvidence& evidence,
                                    const InertialRunSettings& settings);

}  // namespace chasles
