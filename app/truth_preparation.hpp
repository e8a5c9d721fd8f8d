#pragma once

#include <optional>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/check/check_report.hpp>
#include <chasles/eval/truth_examination.hpp>
#include <chasles/eval/truth_tilt.hpp>
#include <chasles/recording/recording.hpp>

#include "truth_options.hpp"

// A truth is examined, the same for `run`, `evaluate` and `check`, and what the options leave to
// its motion is applied.
namespace chasles::app {

/// What is known of a truth, and what to do with it.
struct TruthToPrepare {
  bool attitudes = true;
  Eigen::Vector3d point_imu = Eigen::Vector3d::Zero();  ///< of positions alone [m]
  bool estimate_offset = false;                         ///< --truth-time-offset auto
  bool turn_to_level = false;                           ///< its world is not level
  TruthPairing pairing = {};
};

struct PreparedTruth {
  std::vector<TruthFinding> findings;
  std::optional<TruthTilt> tilt;     ///< that was removed
  bool attitudes = true;             ///< whether there are attitudes to compare with
  std::vector<std::string> remarks;  ///< on what was changed
};

/// Shifts the truth's times by the estimated offset, moves positions of a point on the body to the
/// IMU by the reference's attitudes, turns its world to be level, and examines it. Throws
/// InputError if the offset is to be estimated and the motion does not determine it.
PreparedTruth prepare_truth(const TruthReference& reference, const TruthToPrepare& how,
                            Trajectory& truth);

/// The rotations that the gyroscope of a recording shows, for prepare_truth(). Without poses if the
/// recording has no IMU.
TruthReference gyroscope_reference(const Recording& recording);

/// Adds what the gyroscope shows of the truth to a check. Needs a truth and an IMU.
void report_truth_examination(const Recording& recording, CheckReport& report);

/// The array `truth_findings` of summary.json.
nlohmann::ordered_json truth_findings_json(const std::vector<TruthFinding>& findings);

}  // namespace chasles::app
