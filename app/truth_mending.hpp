#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/eval/truth_reference.hpp>
#include <chasles/recording/recording.hpp>

#include "truth_options.hpp"

// What the user states of a truth is applied to it, before any comparison.
namespace chasles::app {

/// A truth as its file or its recording has it.
struct StatedTruth {
  Trajectory poses;           ///< world_T_imu; without attitudes the rotations are the identity
  std::optional<bool> level;  ///< whether the z axis of its world points up, where that is stated
  bool attitudes = true;      ///< false: positions alone
  Eigen::Vector3d point_imu = Eigen::Vector3d::Zero();  ///< of such positions [m]
};

/// Reads the truth from a TUM file or another table of poses, with remarks on what was mended, from
/// the poses of a bag (FILE or FILE:TOPIC), or from a recording of any kind. Throws InputError if
/// there is none.
StatedTruth read_truth(const std::filesystem::path& path, std::vector<std::string>& remarks);

/// That of a recording, and back.
StatedTruth own_truth(const Recording& recording);
void set_truth(StatedTruth&& truth, Recording& recording);

/// `level`; positions alone count as level, because they do not show whether they begin at an
/// identity.
std::optional<bool> stated_level(const StatedTruth& truth);

/// The cameras of a recording, or of the summary.json of a run.
std::vector<KnownFrame> known_frames(const Recording& recording);
std::vector<KnownFrame> known_frames(const nlohmann::ordered_json& summary);

/// Applies --truth-inverse, --truth-scale, --truth-frame and a stated --truth-time-offset, in this
/// order. `frames`: those that --truth-frame may name. Throws UsageError for a name that is none of
/// them and no file, and InputError for a file that is no transform.
void mend_truth(const TruthOptions& options, const std::vector<KnownFrame>& frames,
                StatedTruth& truth);

/// Whether mend_truth() changes more than times.
bool changes_poses(const TruthOptions& options);

}  // namespace chasles::app
