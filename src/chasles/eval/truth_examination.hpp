#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <chasles/eval/truth_reference.hpp>

// What a truth is, besides poses of the IMU by the right clock in metres (docs/evaluation.md).
namespace chasles {

enum class TruthFault {
  kPositionsOnly,  ///< no attitudes
  kClock,          ///< the times are those of another clock
  kWFirst,         ///< quaternions that were read as x, y, z, w are w, x, y, z
  kConjugate,      ///< the rotations are imu_R_world, the positions are not inverted
  kInverse,        ///< the poses are imu_T_world
  kFrame,          ///< the poses are of another frame on the body
  kPoint,          ///< the positions are of another point on the body
  kUnit,           ///< the positions are not in metres
  kMirrored,       ///< the positions have left-handed axes
  kTilted,         ///< the z axis of the truth's world is not vertical
  kSparse,         ///< its stamps are too far apart for interpolation
  kInterpolated,   ///< interpolation between its stamps is a good part of the errors
  kUnlike,         ///< the rotations follow those of the reference in no reading
  kUnlikePath,     ///< the positions are not those of the reference's path
};

/// "positions_only", "clock", …: names for files.
std::string_view name(TruthFault fault);

struct TruthFinding {
  TruthFault fault = TruthFault::kClock;
  std::string what = {};  ///< with the measured value and its sigma
  double value = 0, sigma = 0, threshold = 0;
  std::string unit = {};
  std::string advice = {};  ///< what to do
};

/// "the truth: WHAT; ADVICE": the same words everywhere.
std::string sentence(const TruthFinding& finding);

/// The clock of the truth: truth's time + offset = reference's time.
struct TruthClock {
  double offset = 0, sigma = 0;  ///< [s]
  bool by_rotations = false;     ///< else by the positions
};

struct TruthExamination {
  std::vector<TruthFinding> findings;
  std::optional<TruthClock> clock;  ///< where the motion determines it, whether it is off or not
  bool attitudes = true;            ///< whether the truth has attitudes to compare with
};

struct TruthExaminationOptions {
  Time gap = kLongestTruthGap;  ///< between poses of the truth that are interpolated
  bool interpolated = true;     ///< whether the truth is interpolated between its stamps
  bool positions_only = false;  ///< as the file states it: then its rotations mean nothing
  bool levelled = false;        ///< its tilt is known, and was removed
};

/// The finding on the unit of the positions, if `scale` of them are a metre by what is compared
/// with, as "the estimate's". None near 1: an estimate's own scale may be off.
std::optional<TruthFinding> unit_finding(double scale, std::string_view other);

/// Examines a truth. Rotations come first: their speed gives the clock whatever the axes are, then
/// the reading and the frame that explain them are chosen, the simplest first. Positions follow.
/// Finds nothing where the motion does not determine it, as with few poses or little rotation.
TruthExamination examine_truth(const TruthReference& reference, const Trajectory& truth,
                               const TruthExaminationOptions& options = {});

}  // namespace chasles
