#include <algorithm>
#include <cmath>
#include <limits>

#include <chasles/eval/attitude_fit.hpp>
#include <chasles/eval/truth_forms.hpp>
#include <chasles/eval/truth_limits.hpp>
#include <chasles/eval/truth_work.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr double kMostSigma = 1 * kRadians;         // of a small turn
constexpr double kBetterAxes = 0.8;                 // of a residual, that a small turn must reach
constexpr double kWorldByAttitudes = 2 * kRadians;  // sigma, where a path leaves a turn open
constexpr double kSteadyAxes = 10 * kRadians;       // of attitudes in one world
constexpr double kSameAxes = 0.2 * kRadians;        // of two cameras
constexpr double kNearer = 0.8;                     // of the rms, for another camera

double angle_of(const Eigen::Matrix3d& R) { return so3::log(R).norm(); }

void turn_axes(const Eigen::Matrix3d& imu_R_truth, Trajectory& truth) {
  for (StampedPose& row : truth) row.pose.R = row.pose.R * imu_R_truth.transpose();
}

// What is left of the attitudes, with any rotation between the worlds, as they are and with those
// axes [rad]. None for rates alone.
BeforeAndAfter attitudes_by_axes(const TruthWork& work, const Eigen::Matrix3d& imu_R_truth) {
  if (work.reference.biased) return {};
  const AttitudeFitOptions options{.offset = work.offset(), .gap = work.gap};
  Trajectory turned = work.mended;
  turn_axes(imu_R_truth, turned);
  const auto before = fit_attitudes(work.reference.poses, work.mended, options);
  const auto after = fit_attitudes(work.reference.poses, turned, options);
  if (!before || !after) return {};
  return {before->rms, after->rms};
}

bool attitudes_agree_better(const TruthWork& work, const Eigen::Matrix3d& imu_R_truth) {
  const BeforeAndAfter rms = attitudes_by_axes(work, imu_R_truth);
  return rms.after && *rms.after < kBetterAxes * *rms.before;
}

// Rates at a wrong shift of the clock, as of a path that repeats itself, show axes that are none.
bool attitudes_contradict(const TruthWork& work, const Eigen::Matrix3d& imu_R_truth) {
  const BeforeAndAfter rms = attitudes_by_axes(work, imu_R_truth);
  return rms.after && *rms.after > 2 * *rms.before + truth_limits::kLeastTurn;
}

// A turn that still counts as the same axes, but is certain and shows in the errors.
bool is_small_turn(const TruthWork& work) {
  const TurningFit& fit = work.turning->fit;
  const double angle = angle_of(fit.reference_R_truth);
  const double least =
      work.reference.biased ? truth_limits::kLeastTurnOfGyroscope : truth_limits::kLeastTurn;
  if (angle < least || fit.rotation_sigma > kMostSigma) return false;
  if (angle < truth_limits::kTurnSigmas * fit.rotation_sigma) return false;
  return fit.residual < kBetterAxes * work.turning->residual ||
         attitudes_agree_better(work, fit.reference_R_truth);
}

Eigen::Matrix3d axes_of(const BodyFrame& frame) {
  return frame.known != nullptr ? frame.known->imu_T_frame.R : frame.imu_R_truth;
}

// Of cameras whose axes are the same, as those of a rectified pair, the one with the positions.
const KnownFrame* nearest_positions(const TruthWork& work, const KnownFrame* frame) {
  if (!work.reference.positions) return frame;
  const auto left = [&](const KnownFrame& of) {
    Trajectory moved = work.mended;
    for (StampedPose& row : moved) row.pose = row.pose * of.imu_T_frame.inverse();
    const auto fit = fit_positions(work.reference.poses, moved,
                                   {.scale = true, .start_offset = work.offset(), .gap = work.gap});
    return fit ? fit->rms / fit->extent : std::numeric_limits<double>::infinity();
  };
  const KnownFrame* best = frame;
  double least = kNearer * left(*frame);
  for (const KnownFrame& other : work.reference.frames) {
    const double apart = angle_of(frame->imu_T_frame.R.transpose() * other.imu_T_frame.R);
    if (&other == frame || apart > kSameAxes) continue;
    const double rms = left(other);
    if (!(rms < least)) continue;
    least = rms;
    best = &other;
  }
  return best;
}

}  // namespace

void frame_by_rates(TruthWork& work) {
  if (!work.turning) return;
  const TurningExplanation& turning = *work.turning;
  const TurningFit& fit = turning.fit;
  if (turning.frame != nullptr) {
    work.frame = {.known = nearest_positions(work, turning.frame), .residual = turning.residual};
  } else if (turning.other_frame || is_small_turn(work)) {
    const double least = turning.other_frame     ? truth_limits::kOtherAxes
                         : work.reference.biased ? truth_limits::kLeastTurnOfGyroscope
                                                 : truth_limits::kLeastTurn;
    work.frame = {.known = nullptr,
                  .imu_R_truth = fit.reference_R_truth,
                  .sigma = fit.rotation_sigma,
                  .threshold = std::max(least, truth_limits::kManySigmas * fit.rotation_sigma),
                  .residual = fit.residual};
  }
  if (!work.frame) return;
  if (attitudes_contradict(work, axes_of(*work.frame))) {
    work.frame.reset();
    work.result.clock.reset();
    return;
  }
  turn_axes(axes_of(*work.frame), work.mended);
}

void frame_by_positions(TruthWork& work) {
  if (work.frame || !is_of_one_path(work.path)) return;
  const double world = std::min(world_sigma(*work.path), kWorldByAttitudes);
  const auto fit =
      attitudes_on_path(work.reference.poses, work.mended, *work.path, work.offset(), work.gap);
  if (!fit || fit->rms > kSteadyAxes) return;
  const double sigma = std::hypot(world, fit->rms / std::sqrt(10.0));
  const double least = std::max(truth_limits::kTurnByPositions, truth_limits::kTurnSigmas * sigma);
  if (angle_of(fit->body) < least) return;
  work.frame = {.imu_R_truth = fit->body, .sigma = sigma, .threshold = least, .residual = {}};
  for (const KnownFrame& known : work.reference.frames) {
    const double apart = angle_of(fit->body.transpose() * known.imu_T_frame.R);
    if (apart > truth_limits::kOtherAxes) continue;
    work.frame->known = nearest_positions(work, &known);
    break;
  }
  turn_axes(axes_of(*work.frame), work.mended);
  move_from_known_frame(work);
}

void report_frame(TruthWork& work) {
  const auto point = other_point(work);
  if (!work.frame) {
    if (point) work.find(point_finding(*point));
    return;
  }
  if (work.frame->known == nullptr) {
    work.find(other_frame_finding(work.reference, *work.frame, point));
    return;
  }
  work.find(known_frame_finding(work.reference, *work.frame));
  if (point) work.find(beside_frame_finding(*work.frame->known, *point));
}

}  // namespace chasles
