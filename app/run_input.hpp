#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <chasles/data/reader_settings.hpp>
#include <chasles/data/recording.hpp>
#include <chasles/pipeline/tracks_part.hpp>

#include "truth_options.hpp"

namespace chasles::app {

/// Input of a run, without its settings.
struct RunInput {
  std::filesystem::path recording;
  std::filesystem::path truth;  ///< TUM; empty: that of the recording, if any
  TruthOptions truth_options = {};
  std::optional<double> start, stop;  ///< seconds since the recording's first event
  bool backwards = false;             ///< reverse, after cutting
  std::string cameras;                ///< "mono", "stereo"; empty: all cameras
  TracksPart tracks = {};             ///< with images, applied during the run
  ReaderSettings reader = {};
};

/// Reads the recording of a run, cuts it to [start, stop], and replaces the truth if another one is
/// given. Decides `truth_level` (is_truth_level()) where there is a truth. Throws InputError as the
/// readers do, and for a truth that has no time in common with the frames. Throws UsageError if
/// start and stop leave nothing, or cameras are missing. Throws Error(kNotInitialised) for a
/// recording without frames, or with neither velocities nor IMU samples.
Recording read_input(const RunInput& input);

/// A truth, and whether its world's z axis points up where its recording states it.
struct StatedTruth {
  Trajectory poses;  ///< world_T_imu
  std::optional<bool> level;
};

/// Reads the truth from a TUM file, with remarks on what was mended, or from a recording of any
/// kind. Throws InputError if there is none.
StatedTruth read_truth(const std::filesystem::path& path, std::vector<std::string>& remarks);

/// Replaces the velocities by those that move the pose exactly along the trajectory (world_T_imu),
/// each held until the next one (hold `zero-order`). The first pose becomes the world frame.
/// Removes frames outside the trajectory's time span and counts them in a remark. Throws InputError
/// if the trajectory has fewer than two poses, or no frame lies in its time span.
void follow(Recording& recording, const Trajectory& trajectory);

}  // namespace chasles::app
