#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <chasles/pipeline/tracks_part.hpp>
#include <chasles/recording/reader_settings.hpp>
#include <chasles/recording/recording.hpp>
#include <chasles/session/truth_mending.hpp>
#include <chasles/session/truth_options.hpp>

namespace chasles {

/// Input of a run, without its settings.
struct RecordingInput {
  std::filesystem::path recording;
  std::filesystem::path truth;  ///< as read_truth(); empty: that of the recording, if any
  TruthOptions truth_options = {};
  std::optional<double> start, stop;  ///< seconds since the recording's first event
  bool backwards = false;             ///< reverse, after cutting
  std::string cameras;                ///< as camera_choice(); empty: all cameras
  TracksPart tracks = {};             ///< with images, applied during the run
  ReaderSettings reader = {};
};

/// Reads the recording of a run, cuts it to [start, stop], and replaces the truth if another one is
/// given. Decides `truth_level` (is_truth_level()) where there is a truth. Throws InputError as the
/// readers do, and for a truth that has no time in common with the frames. Throws UsageError if
/// start and stop leave nothing, or cameras are missing. Throws Error(kNotInitialised) for a
/// recording without frames, or with neither velocities nor IMU samples.
Recording read_input(const RecordingInput& input);

/// Replaces the truth of a recording by that of a file, as read_truth() and mend_truth() have it,
/// and drops what is in the world of its own truth. Decides `truth_level`. Throws as these do.
void replace_truth(Recording& recording, const std::filesystem::path& file,
                   const TruthOptions& options);

/// The recording's own truth in the form that the options state: as mend_truth(). What is in the
/// world or by the clock of the truth follows or is dropped.
void mend_own_truth(Recording& recording, const TruthOptions& options);

/// Replaces the velocities by those that move the pose exactly along the trajectory (world_T_imu),
/// each held until the next one (hold `zero-order`). The first pose becomes the world frame.
/// Removes frames outside the trajectory's time span and counts them in a remark. Throws InputError
/// if the trajectory has fewer than two poses, or no frame lies in its time span.
void follow(Recording& recording, const Trajectory& trajectory);

}  // namespace chasles
