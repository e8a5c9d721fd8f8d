#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include <chasles/data/recording.hpp>
#include <chasles/pipeline/tracks_part.hpp>
#include <chasles/slam/velocity_noise.hpp>
#include <chasles/slam/velocity_settings.hpp>

namespace chasles::app {

/// What a run is given besides its settings.
struct RunInput {
  std::filesystem::path recording;
  std::filesystem::path truth;        ///< TUM; empty: the recording's own, if it has one
  std::optional<double> start, stop;  ///< seconds since the recording's first event
  bool backwards = false;             ///< after the cut
  std::string cameras;                ///< "mono", "stereo"; empty: all that there are
  TracksPart tracks = {};             ///< of images it is the run that leaves out the others
};

/// The recording that the run works on: cut to start … stop, with the truth of its choice. Throws
/// InputError as the readers do, and for a truth that has no stamps in common with the frames;
/// UsageError where start and stop leave nothing, or cameras are missing; Error(kNotInitialised)
/// for a recording without a frame or velocity.
Recording read_input(const RunInput& input);

/// The truth of a TUM file, or of a recording of any kind that has one. InputError where not.
Trajectory read_truth(const std::filesystem::path& path);

/// Replaces the velocities by those that, each held until the next (hold `zero-order`), move the
/// pose exactly along the trajectory, from its first pose on, which becomes the world. Frames
/// outside of its time are taken out of the recording, and counted in a remark.
void follow(Recording& recording, const Trajectory& trajectory);

}  // namespace chasles::app
