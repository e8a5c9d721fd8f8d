#include <chasles/eval/truth_limits.hpp>
#include <chasles/eval/truth_work.hpp>

namespace chasles {
namespace {

constexpr double kLeastMirrored = 0.05;  // of the extent, that a rotation leaves
constexpr double kLeastSpread = 0.1;     // of an estimate that shows a path [m]

bool is_mirrored(const PositionFit& fit) {
  return fit.mirrored_rms < truth_limits::kMirrorGain * fit.rms &&
         fit.mirrored_rms < truth_limits::kMirrorGain * fit.extent &&
         fit.rms > kLeastMirrored * fit.extent;
}

PositionFitOptions path_options(const TruthWork& work) {
  return {.start_offset = work.offset(), .gap = work.gap};
}

// Positions that are not of the estimate's path.
void examine_unlike(TruthWork& work) {
  const double size = spread(work.estimate);
  if (size < kLeastSpread) return;
  if (spread(work.truth) == 0) {
    work.find(one_position_finding(work.truth.size(), size));
    return;
  }
  if (!work.path) return;
  if (const auto order = find_degrees(work.estimate, work.mended, path_options(work))) {
    work.find(degrees_finding(*order));
  } else if (work.path->rms > truth_limits::kUnlikePath * work.path->extent) {
    work.find(unlike_path_finding(*work.path));
  }
}

}  // namespace

void examine_path(TruthWork& work) {
  if (!work.reference.positions) return;
  work.path = fit_path(work.estimate, work.mended, path_options(work));
  if (work.path && is_mirrored(*work.path)) {
    work.find(mirrored_finding(*work.path));
    return;
  }
  if (!is_of_one_path(work.path)) {
    examine_unlike(work);
    return;
  }
  const PositionFit& fit = *work.path;
  if (const auto finding = unit_finding(fit.scale, "the estimate's")) {
    work.find(*finding);
    for (StampedPose& row : work.mended) row.pose.p /= fit.scale;
  }
  if (work.frame && work.frame->known != nullptr) {
    move_from_known_frame(work);
  } else {
    for (StampedPose& row : work.estimate) row.pose.p += row.pose.R * fit.point;
  }
}

void move_from_known_frame(TruthWork& work) {
  if (work.frame->known == nullptr) return;
  for (StampedPose& row : work.mended) row.pose.p -= row.pose.R * work.frame->known->imu_T_frame.p;
  work.estimate = work.reference.poses;
  const auto path = fit_path(work.estimate, work.mended, path_options(work));
  if (!is_of_one_path(path)) return;
  work.path = path;
  for (StampedPose& row : work.estimate) row.pose.p += row.pose.R * path->point;
}

std::optional<PositionFit> other_point(const TruthWork& work) {
  if (!is_of_one_path(work.path)) return std::nullopt;
  PositionFitOptions options = path_options(work);
  options.point = true;
  options.offset = !work.result.clock || !work.result.clock->by_rotations;
  const Trajectory& estimate = work.reference.poses;
  const auto with = fit_positions(estimate, work.mended, options);
  options.point = false;
  const auto without = fit_positions(estimate, work.mended, options);
  return with && without && is_clear_point(*with, *without) ? with : std::nullopt;
}

}  // namespace chasles
