#pragma once

#include <optional>

#include <chasles/eval/truth_reference.hpp>
#include <chasles/eval/turning.hpp>

namespace chasles {

/// What the numbers of a truth's quaternions may be.
enum class TruthReading {
  kAsRead,
  kWFirst,         ///< w, x, y, z, read as x, y, z, w
  kInverse,        ///< of imu_R_world
  kWFirstInverse,  ///< both
};

bool is_w_first(TruthReading reading);
bool is_inverse(TruthReading reading);

/// The rotation in that reading.
Eigen::Matrix3d read_as(TruthReading reading, const Eigen::Matrix3d& R);

/// The truth with all its rotations in that reading; the positions stay.
Trajectory read_as(TruthReading reading, Trajectory truth);

/// The simplest explanation of a truth's rotations.
struct TurningExplanation {
  TruthReading reading = TruthReading::kAsRead;
  const KnownFrame* frame = nullptr;  ///< the body frame that turns so; null: the IMU, or another
  bool other_frame = false;           ///< of a frame that is not known: fit.reference_R_truth
  bool clock_is_clear = true;         ///< false: another shift of the clock explains them as well
  TurningFit fit;                     ///< in that reading, with a free rotation
  double residual = 0;                ///< with the axes of the IMU or of `frame` [rad/s]
};

struct TurningEvidence {
  std::optional<TurningExplanation> explanation;
  /// Both turn, and for long enough, but in no reading alike.
  bool unlike = false;
  double unexplained = 1e9;  ///< the share of the best reading, if any was compared
};

/// Tries readings and frames from the simplest: as read and of the IMU; of a known frame, the best
/// of them; w first; inverse; both; then of any frame. The first that explains the rates as well as
/// the best free rotation, but for 6 degrees between the axes, is the explanation. The rates are
/// those over 0.1 s, or else over 0.5 or 1 s, because attitudes may be noisy. `only`: no other
/// reading is tried.
TurningEvidence explain_turning(const TruthReference& reference, const Trajectory& truth, Time gap,
                                std::optional<TruthReading> only = {});

}  // namespace chasles
