#pragma once

#include <optional>

#include <chasles/eval/attitude_fit.hpp>
#include <chasles/eval/truth_examination.hpp>
#include <chasles/eval/truth_interpolation.hpp>
#include <chasles/eval/truth_path.hpp>
#include <chasles/eval/truth_reading.hpp>

// The findings on a truth in words.
namespace chasles {

TruthFinding positions_only_finding(const TruthReference& reference, std::size_t poses,
                                    bool stated);
/// By the rates, of which that share is unexplained; by attitudes after the best rotations.
TruthFinding unlike_finding(const TruthReference& reference, double unexplained);
TruthFinding unlike_attitudes_finding(const TruthReference& reference, const AttitudeFit& fit);
TruthFinding w_first_finding(const TruthReference& reference, const TurningExplanation& turning);
/// `whole`: the poses are inverse, not their rotations alone.
TruthFinding inverse_finding(const TruthReference& reference, const TurningExplanation& turning,
                             bool whole);

/// A figure with the truth as it is and mended, where known.
struct BeforeAndAfter {
  std::optional<double> before, after;
};
/// `ate` [m]; `attitudes`: the angles that the best rotation between the worlds leaves [rad].
/// `least`: the smallest offset that is a finding [s].
TruthFinding clock_finding(const TruthReference& reference, const TruthClock& clock, double least,
                           const BeforeAndAfter& ate, const BeforeAndAfter& attitudes);
/// Both in seconds.
TruthFinding sparse_finding(double spacing, double longest_gap);
TruthFinding interpolated_finding(const InterpolationError& error, double spacing);

/// The frame on the body that the poses are of.
struct BodyFrame {
  const KnownFrame* known = nullptr;  ///< null: another one, with that rotation
  Eigen::Matrix3d imu_R_truth = Eigen::Matrix3d::Identity();
  double sigma = 0;                ///< of that rotation [rad]
  double threshold = 0;            ///< the least angle that is a finding [rad]
  std::optional<double> residual;  ///< of the rates with that rotation [rad/s]; none: by positions
};
TruthFinding known_frame_finding(const TruthReference& reference, const BodyFrame& frame);
/// `point`: in the axes of the IMU, if another one is clear.
TruthFinding other_frame_finding(const TruthReference& reference, const BodyFrame& frame,
                                 const std::optional<PositionFit>& point);
TruthFinding point_finding(const PositionFit& fit);
/// Of poses with the axes of a known frame: the point is seen from the IMU after the frame.
TruthFinding beside_frame_finding(const KnownFrame& frame, const PositionFit& point);
/// Of positions that no similarity maps to the estimate's path.
TruthFinding unlike_path_finding(const PositionFit& fit);
TruthFinding degrees_finding(DegreesOrder order);
TruthFinding one_position_finding(std::size_t poses, double estimate_spread);
TruthFinding mirrored_finding(const PositionFit& fit);
/// `up`: the vertical in the truth's world; `tilt` [rad].
TruthFinding tilt_finding(const TruthReference& reference, const Eigen::Vector3d& up, double tilt);

}  // namespace chasles
