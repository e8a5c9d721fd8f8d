#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <chasles/eval/ate.hpp>
#include <chasles/eval/nees.hpp>
#include <chasles/eval/rpe.hpp>
#include <chasles/eval/table.hpp>

namespace chasles {

/// What to compute. The defaults are those of every table of the project.
struct EvaluationOptions {
  TruthPairing pairing;  ///< of estimate and truth
  std::vector<Alignment> alignments = {Alignment::kRigid, Alignment::kPositionYaw,
                                       Alignment::kFirstPose};
  RelativeErrorOptions relative;
  PoseError pose_error = PoseError::kStandard;
  bool level = false;  ///< z points up in the estimate's world: as in nees()
  /// False: the truth has positions alone. Attitude errors, relative errors, errors after the first
  /// pose's alignment and NEES of attitude and pose then have no value.
  bool attitudes = true;
};

/// An estimate compared with the truth (docs/evaluation.md defines each figure).
struct Evaluation {
  std::size_t matched = 0;       ///< stamps compared
  std::size_t interpolated = 0;  ///< of these, stamps between two of the truth
  std::size_t estimates = 0;     ///< poses of the estimate
  std::size_t truths = 0;        ///< poses of the truth
  double duration_s = 0;         ///< from the first to the last matched stamp
  double path_m = 0;             ///< the truth's path through the matched stamps
  std::vector<AbsoluteError> absolute;
  std::vector<RelativeError> over_distance;
  std::vector<RelativeError> over_time;
  std::optional<Nees> nees;  ///< only with covariances
};

/// Evaluates an estimate of world_T_imu. `covariances`: none, or one for each pose of the estimate,
/// as nees() takes them. Throws InputError as associate() and nees() do. O(n).
Evaluation evaluate(const Trajectory& estimate, const Trajectory& truth,
                    std::span<const Matrix6d> covariances = {},
                    const EvaluationOptions& options = {});

/// The absolute error after that alignment, or null if it was not computed.
const AbsoluteError* find(const Evaluation& evaluation, Alignment alignment);

/// The figures with the names of docs/evaluation.md (ate_m, ate_posyaw_m, ate_first_pose_m,
/// attitude_deg, rpe_100m_percent, nees_position, nees_attitude, nees_pose, within_3_sigma_rx to
/// within_3_sigma_z) and some more, in a fixed order. Figures that do not apply have no value.
std::vector<std::pair<std::string, std::optional<double>>> figures(const Evaluation& evaluation);

/// One row per alignment: position and attitude errors.
Table absolute_table(const Evaluation& evaluation);

/// One row per length: relative errors. Lengths without a piece are left out.
Table distance_table(const Evaluation& evaluation);
Table time_table(const Evaluation& evaluation);

/// One row each for position, attitude and pose; empty without covariances.
Table nees_table(const Evaluation& evaluation);

/// One row: for each axis the share of the poses whose error is within 3 of its own sigmas [%].
/// Empty without covariances.
Table within_3_sigma_table(const Evaluation& evaluation);

/// All tables as text.
std::string to_text(const Evaluation& evaluation);

}  // namespace chasles
