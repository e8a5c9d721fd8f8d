#pragma once

#include <optional>

#include <nlohmann/json_fwd.hpp>

#include <chasles/data/recording.hpp>
#include <chasles/data/run.hpp>
#include <chasles/slam/inertial_session.hpp>
#include <chasles/smooth/batch/batch.hpp>
#include <chasles/smooth/window/window.hpp>

#include "estimator.hpp"
#include "inertial_settings_io.hpp"
#include "realtime.hpp"
#include "tracks_part.hpp"

namespace chasles::app {

class Interrupt;
class LiveView;

/// How a recording with an IMU is run.
struct InertialDriveOptions {
  bool from_truth = false;  ///< begin at the true state of the first frame that has one
  int threads = 3;          ///< as SensorFeedOptions::threads
  bool quiet = false;
  /// Recorded seconds in a second: the recording comes at that speed, and frames that come while
  /// too many wait are dropped. None: as fast as it is worked through, and nothing is dropped.
  std::optional<double> realtime;
  /// The filter's run is where batch estimation begins, and is replaced by what that finds. A
  /// window goes through the recording in the filter's stead, from the filter's first estimate on.
  Estimator estimator = {};
  std::optional<int> keep_images;  ///< as for ImageKeeper
  TracksPart tracks = {};          ///< of those that the front end follows
};

/// What the front end did, summed over the frames.
struct FrontendTotals {
  int frames = 0;
  int unreadable = 0;  ///< images, taken for missing
  long tracked = 0, added = 0, lost = 0, outliers = 0, stereo_tried = 0, stereo_matched = 0;
  double seconds = 0;  ///< that it took, without reading the images
};

/// A recording with an IMU after the filter has gone through it.
struct InertialDrive {
  Run run;
  ImuBuffer::Counts imu;
  ImuNoise imu_noise;
  double pixel_sigma = 0;               ///< [px]
  std::optional<double> start_seconds;  ///< of the first estimate, since the first frame
  int resets = 0;                       ///< of a lost filter
  int zupt_frames = 0;                  ///< at rest, which the filter was told
  int dropped_frames = 0;               ///< late, there twice, or without samples near
  FrontendTotals frontend;              ///< of a recording with images
  double filter_seconds = 0;            ///< that start and filter, or window, took
  std::optional<double> nees_state;     ///< mean; where the truth has velocity and biases
  std::optional<double> innovation_correlation;
  bool interrupted = false;  ///< by a signal: `run` ends early
  std::optional<RealtimeFigures> realtime;
  std::optional<BatchReport> batch;        ///< of batch estimation; run is what it found
  std::optional<WindowReport> window;      ///< the same of a window
  std::optional<Calibration> calibration;  ///< the last estimate's, where it is estimated
};

/// Throws Error(kNotInitialised) with what was missing where no start was found, InputError where
/// cameras or the IMU's noise are missing; what smooth() (smooth/batch.hpp) and
/// InertialWindow (smooth/inertial_window.hpp) throw.
InertialDrive drive(const Recording& recording, const InertialRunSettings& settings,
                    const InertialDriveOptions& options, const Interrupt& interrupt,
                    LiveView& live);

/// timing.json: that of the other recordings, with the milliseconds that front end and filter took
/// a frame, and how the run kept up in real time.
nlohmann::ordered_json timing_json(const InertialDrive& drive,
                                   const nlohmann::ordered_json& timing);

/// What of summary.json is known before the run, as of the other recordings.
nlohmann::ordered_json known_json(const InertialRunSettings& settings, const Recording& recording);

/// summary.json, as that of the other recordings.
nlohmann::ordered_json summary_json(const InertialDrive& drive, const InertialRunSettings& settings,
                                    const Recording& recording);

}  // namespace chasles::app
