#include <algorithm>
#include <cmath>
#include <vector>

#include <chasles/constants.hpp>
#include <chasles/eval/alignment.hpp>
#include <chasles/eval/lag.hpp>
#include <chasles/eval/position_fit.hpp>
#include <chasles/eval/positions_only.hpp>
#include <chasles/eval/truth_examination.hpp>
#include <chasles/eval/truth_reading.hpp>
#include <chasles/eval/truth_sentences.hpp>

namespace chasles {
namespace {

constexpr double kManySigmas = 5;       // sigmas
constexpr double kLeastOffset = 0.002;  // [s]
constexpr double kLeastOffsetWithoutPositions = 0.005;
constexpr double kMostOffsetSigma = 0.05;
constexpr double kAlikePositions = 1.3;                // of the rms of two shifts
constexpr double kSameShift = 0.05, kNearShift = 0.6;  // [s]
constexpr double kBetter = 0.9;                        // of the ATE, that a clock must reach
constexpr double kShape = 0.2;        // of the extent, that positions of one path may differ
constexpr double kMirrorGain = 0.2;   // of the rms, that a reflection leaves
constexpr double kLeastPoint = 0.02;  // [m]
constexpr double kPointGain = 0.35;   // of the rms, that a point on the body leaves
constexpr double kTilt = 5 * kRadians, kTiltOfUnknown = 20 * kRadians;

// The examination in progress. `mended` is the truth in the reading and frame that were found.
struct Work {
  const TruthReference& reference;
  const Trajectory& truth;
  Time gap;
  Trajectory mended;
  std::optional<TurningExplanation> turning = {};
  std::optional<PositionFit> shape = {};  // with a free scale
  TruthExamination result = {};

  double offset() const { return result.clock ? result.clock->offset : 0; }
  void find(TruthFinding finding) { result.findings.push_back(std::move(finding)); }
};

PositionFitOptions fit_options(const Work& work, bool scale) {
  return {.scale = scale, .start_offset = work.offset(), .gap = work.gap};
}

bool is_of_one_path(const std::optional<PositionFit>& fit) {
  return fit && fit->rms < kShape * fit->extent;
}

Trajectory inverse_of(Trajectory poses) {
  for (StampedPose& row : poses) row.pose = row.pose.inverse();
  return poses;
}

void read_turning(Work& work) {
  const TurningEvidence evidence = explain_turning(work.reference, work.truth, work.gap);
  work.turning = evidence.explanation;
  if (!work.turning) {
    if (evidence.unlike) work.find(unlike_finding(work.reference, evidence.unexplained));
    return;
  }
  const TurningFit& fit = work.turning->fit;
  if (work.turning->clock_is_clear && fit.offset_sigma < kMostOffsetSigma) {
    work.result.clock = {.offset = fit.offset, .sigma = fit.offset_sigma, .by_rotations = true};
  }
  work.mended = read_as(work.turning->reading, std::move(work.mended));
}

// Positions of inverse poses look like those of no path.
void read_inverse(Work& work) {
  if (!work.turning || work.turning->reading == TruthReading::kAsRead) return;
  if (work.turning->reading == TruthReading::kWFirst) {
    work.find(w_first_finding(work.reference, *work.turning));
    return;
  }
  bool whole = false;
  if (work.reference.positions) {
    const Trajectory inverse = inverse_of(work.truth);
    const auto as_read = fit_positions(work.reference.poses, work.truth, fit_options(work, true));
    const auto inverted = fit_positions(work.reference.poses, inverse, fit_options(work, true));
    whole = inverted &&
            (!as_read || inverted->rms / inverted->extent < 0.5 * as_read->rms / as_read->extent);
    if (whole) work.mended = inverse;
  }
  work.find(inverse_finding(work.reference, *work.turning, whole));
}

void move_to_imu(Work& work) {
  if (!work.turning) return;
  SE3 imu_T_truth;
  if (work.turning->frame != nullptr) {
    imu_T_truth = work.turning->frame->imu_T_frame;
  } else if (work.turning->other_frame) {
    imu_T_truth.R = work.turning->fit.reference_R_truth;
  }
  for (StampedPose& row : work.mended) row.pose = row.pose * imu_T_truth.inverse();
}

// Where no rotation tells it, the positions give the clock: of several shifts that fit alike the
// one near zero, or none.
void clock_by_positions(Work& work) {
  if (work.result.clock || !work.reference.positions) return;
  const Trajectory& estimate = work.reference.poses;
  std::vector<PositionFit> fits;
  for (const Lag& lag : find_lags(estimate, work.mended, SpeedKind::kMoving, false, work.gap)) {
    PositionFitOptions options = fit_options(work, true);
    options.start_offset = lag.offset;
    options.offset = true;
    const auto one = fit_positions(estimate, work.mended, options);
    if (is_of_one_path(one) && one->offset_sigma < kMostOffsetSigma) fits.push_back(*one);
  }
  if (fits.empty()) return;
  const double best = std::ranges::min_element(fits, {}, &PositionFit::rms)->rms;
  std::erase_if(fits, [&](const PositionFit& one) { return one.rms > kAlikePositions * best; });
  const auto size = [](const PositionFit& one) { return std::abs(one.offset); };
  const PositionFit fit = *std::ranges::min_element(fits, {}, size);
  const bool clear = std::ranges::none_of(fits, [&](const PositionFit& other) {
    return std::abs(other.offset - fit.offset) > kSameShift;
  });
  if (!clear && size(fit) > kNearShift) return;
  work.result.clock = {.offset = fit.offset, .sigma = fit.offset_sigma};
}

// Few stamps of the truth are near those of the estimate, and nothing lies between them.
void examine_spacing(Work& work, const TruthExaminationOptions& options) {
  const Time spacing = median_spacing(work.truth);
  if (!options.interpolated || !work.reference.positions || spacing <= options.gap) return;
  if (spacing <= 2 * median_spacing(work.reference.poses)) return;
  work.find(sparse_finding(to_seconds(spacing), to_seconds(options.gap)));
}

void examine_shape(Work& work) {
  if (!work.reference.positions) return;
  const Trajectory& estimate = work.reference.poses;
  work.shape = fit_positions(estimate, work.mended, fit_options(work, true));
  if (!work.shape) return;
  const PositionFit& fit = *work.shape;
  if (fit.mirrored_rms < kMirrorGain * fit.rms && fit.mirrored_rms < kShape * fit.extent &&
      fit.rms > 0.05 * fit.extent) {
    work.find(mirrored_finding(fit));
    return;
  }
  if (!is_of_one_path(work.shape)) return;
  if (const auto finding = unit_finding(fit)) {
    work.find(*finding);
    for (StampedPose& row : work.mended) row.pose.p /= fit.scale;
  }
}

void examine_clock(Work& work) {
  if (!work.result.clock) return;
  const TruthClock& clock = *work.result.clock;
  const double size = std::abs(clock.offset);
  if (!work.reference.positions) {
    if (size <= std::max(kLeastOffsetWithoutPositions, kManySigmas * clock.sigma)) return;
    work.find(clock_finding(work.reference, clock, kLeastOffsetWithoutPositions, {}, {}));
    return;
  }
  if (size <= std::max(kLeastOffset, kManySigmas * clock.sigma)) return;
  const Trajectory& estimate = work.reference.poses;
  const auto before = aligned_rms(estimate, work.mended, 0, work.gap);
  const auto after = aligned_rms(estimate, work.mended, clock.offset, work.gap);
  if (!after || (before && *after > kBetter * *before)) return;
  work.find(clock_finding(work.reference, clock, kLeastOffset, before, after));
}

// The point on the body whose positions the truth has, if it is clearly another one.
std::optional<PositionFit> other_point(const Work& work) {
  if (!is_of_one_path(work.shape)) return std::nullopt;
  PositionFitOptions options = fit_options(work, false);
  options.point = true;
  options.offset = !work.result.clock || !work.result.clock->by_rotations;
  const auto fit = fit_positions(work.reference.poses, work.mended, options);
  options.point = false;
  const auto without = fit_positions(work.reference.poses, work.mended, options);
  const bool clear = fit && without && fit->point.norm() > kLeastPoint &&
                     fit->point.norm() > 8 * fit->point_sigma &&
                     fit->rms < kPointGain * without->rms;
  return clear ? fit : std::nullopt;
}

void examine_frame(Work& work) {
  const bool turned = work.turning && (work.turning->frame != nullptr || work.turning->other_frame);
  if (turned && work.turning->frame != nullptr) {
    work.find(known_frame_finding(work.reference, *work.turning));
    return;
  }
  const auto point = other_point(work);
  if (turned) {
    work.find(other_frame_finding(work.reference, *work.turning, point));
  } else if (point) {
    work.find(point_finding(*point));
  }
}

// truth_R_reference of the worlds, by the attitudes, or else by the positions if they spread
// enough.
std::optional<Eigen::Matrix3d> between_worlds(const Work& work) {
  if (!work.turning) {
    if (work.result.attitudes || !is_of_one_path(work.shape)) return std::nullopt;
    const bool spread = work.shape->rms < 0.02 * work.shape->breadth;
    return spread ? std::optional(work.shape->truth_T_estimate.R) : std::nullopt;
  }
  MatchedTrajectories matched;
  for (const StampedPose& row : work.reference.poses) {
    const auto truth = pose_at(work.mended, row.time - from_seconds(work.offset()), work.gap);
    if (!truth) continue;
    matched.estimate.push_back({row.time, {row.pose.R, Eigen::Vector3d::Zero()}});
    matched.truth.push_back({row.time, {truth->R, Eigen::Vector3d::Zero()}});
  }
  if (matched.truth.empty()) return std::nullopt;
  return align(matched, Alignment::kRigid).truth_T_estimate.R;
}

void examine_tilt(Work& work) {
  if (work.reference.biased || work.reference.level == false) return;
  const auto truth_R_reference = between_worlds(work);
  if (!truth_R_reference) return;
  const Eigen::Vector3d up = truth_R_reference->col(2);
  const double tilt = std::atan2(up.head<2>().norm(), up.z());
  if (tilt > (work.reference.level ? kTilt : kTiltOfUnknown)) {
    work.find(tilt_finding(work.reference, up, tilt));
  }
}

}  // namespace

TruthExamination examine_truth(const TruthReference& reference, const Trajectory& truth,
                               const TruthExaminationOptions& options) {
  Work work{.reference = reference, .truth = truth, .gap = options.gap, .mended = truth};
  if (truth.size() < 3 || reference.poses.size() < 3) return work.result;
  work.gap = std::max(options.gap, 3 * median_spacing(truth) / 2);
  work.result.attitudes = !options.positions_only && !is_without_attitudes(reference.poses, truth);
  if (!work.result.attitudes) {
    work.find(positions_only_finding(reference, truth.size(), options.positions_only));
  } else {
    read_turning(work);
    read_inverse(work);
    move_to_imu(work);
  }
  clock_by_positions(work);
  examine_shape(work);
  examine_clock(work);
  examine_spacing(work, options);
  examine_frame(work);
  examine_tilt(work);
  return work.result;
}

}  // namespace chasles
