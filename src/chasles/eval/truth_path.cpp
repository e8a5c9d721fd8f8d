#include <algorithm>
#include <cmath>

#include <chasles/eval/truth_limits.hpp>
#include <chasles/eval/truth_path.hpp>

namespace chasles {
namespace {

constexpr double kShape = 0.2;       // of the extent, that positions of one path may differ
constexpr double kPointGain = 0.35;  // of the rms, that a point on the body leaves
constexpr double kMostPoint = 30;    // [m]

// East, north and up in metres, on a sphere near the first position; none for what is no degrees.
std::optional<Trajectory> metres_of(Trajectory poses, DegreesOrder order) {
  constexpr double kMetresPerDegree = 111'195, kMostSpan = 1;
  const int north = order == DegreesOrder::kLatitudeFirst ? 0 : 1, east = 1 - north;
  const Eigen::Vector3d first = poses.front().pose.p;
  const double across = kMetresPerDegree * std::cos(first[north] * kRadians);
  for (StampedPose& row : poses) {
    const Eigen::Vector3d p = row.pose.p, d = p - first;
    if (std::abs(p[north]) > 90 || std::abs(p[east]) > 180) return std::nullopt;
    if (std::max(std::abs(d[0]), std::abs(d[1])) > kMostSpan) return std::nullopt;
    row.pose.p = {across * d[east], kMetresPerDegree * d[north], d.z()};
  }
  return poses;
}

}  // namespace

bool is_of_one_path(const std::optional<PositionFit>& fit) {
  return fit && fit->rms < kShape * fit->extent;
}

bool is_clear_point(const PositionFit& with, const PositionFit& without) {
  const double away = with.point.norm();
  return away > truth_limits::kLeastPoint && away < kMostPoint &&
         away > truth_limits::kPointSigmas * with.point_sigma &&
         with.rms < kPointGain * without.rms;
}

std::optional<PositionFit> fit_path(const Trajectory& estimate, const Trajectory& truth,
                                    PositionFitOptions options) {
  options.scale = true;
  options.point = false;
  const auto without = fit_positions(estimate, truth, options);
  if (!without) return std::nullopt;
  options.point = true;
  const auto with = fit_positions(estimate, truth, options);
  return with && is_clear_point(*with, *without) ? with : without;
}

double world_sigma(const PositionFit& fit) { return fit.rms / std::max(fit.breadth, 1e-12); }

double spread(const Trajectory& poses) {
  if (poses.empty()) return 0;
  const auto n = static_cast<double>(poses.size());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const StampedPose& row : poses) mean += row.pose.p / n;
  double sum = 0;
  for (const StampedPose& row : poses) sum += (row.pose.p - mean).squaredNorm() / n;
  return std::sqrt(sum);
}

std::optional<DegreesOrder> find_degrees(const Trajectory& estimate, const Trajectory& truth,
                                         const PositionFitOptions& options) {
  std::optional<DegreesOrder> found;
  double least = kShape;
  for (const DegreesOrder order : {DegreesOrder::kLatitudeFirst, DegreesOrder::kLongitudeFirst}) {
    const auto metres = metres_of(truth, order);
    const auto fit = metres ? fit_path(estimate, *metres, options) : std::nullopt;
    // North, east and up are left-handed: a fault of its own.
    const double left = fit ? std::min(fit->rms, fit->mirrored_rms) / fit->extent : kNaN;
    if (!(left < least)) continue;
    least = left;
    found = order;
  }
  return found;
}

}  // namespace chasles
