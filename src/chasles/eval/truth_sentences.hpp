#pragma once

#include <optional>

#include <chasles/eval/position_fit.hpp>
#include <chasles/eval/truth_examination.hpp>
#include <chasles/eval/truth_reading.hpp>

// The findings on a truth in words.
namespace chasles {

TruthFinding positions_only_finding(const TruthReference& reference, std::size_t poses,
                                    bool stated);
TruthFinding unlike_finding(const TruthReference& reference, double unexplained);
TruthFinding w_first_finding(const TruthReference& reference, const TurningExplanation& turning);
/// `whole`: the poses are inverse, not their rotations alone.
TruthFinding inverse_finding(const TruthReference& reference, const TurningExplanation& turning,
                             bool whole);
/// `before`, `after`: the ATE with the clock as it is, and corrected, where known [m].
/// `least`: the smallest offset that is a finding [s].
TruthFinding clock_finding(const TruthReference& reference, const TruthClock& clock, double least,
                           std::optional<double> before, std::optional<double> after);
/// Both in seconds.
TruthFinding sparse_finding(double spacing, double longest_gap);
TruthFinding known_frame_finding(const TruthReference& reference,
                                 const TurningExplanation& turning);
TruthFinding other_frame_finding(const TruthReference& reference, const TurningExplanation& turning,
                                 const std::optional<PositionFit>& point);
TruthFinding point_finding(const PositionFit& fit);
TruthFinding mirrored_finding(const PositionFit& fit);
/// None if the scale is that of metres, or near it: an estimate's own scale may be off.
std::optional<TruthFinding> unit_finding(const PositionFit& fit);
/// `up`: the vertical in the truth's world; `tilt` [rad].
TruthFinding tilt_finding(const TruthReference& reference, const Eigen::Vector3d& up, double tilt);

}  // namespace chasles
