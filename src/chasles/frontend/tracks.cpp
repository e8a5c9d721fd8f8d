#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>

#include <chasles/base/stage_clock.hpp>
#include <chasles/frontend/coverage.hpp>
#include <chasles/frontend/tracks.hpp>
#include <chasles/frontend/two_view.hpp>
#include <chasles/frontend/view_transfer.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

/// A track in the old image and in the new one.
struct Pair {
  Track last, now;
};

/// Interval of the search for the kept patch [images]. The search costs as much as following, and
/// errors accumulate slowly.
constexpr int kEvery = 3;

/// Minimum correlation with the kept patch. Noise also lowers the correlation with the last image;
/// up to twice its loss is allowed.
double least_kept_correlation(const FrontendSettings& settings, const Followed& followed) {
  return std::min(settings.min_kept_correlation, 1 - 2 * (1 - followed.correlation));
}

/// The largest factor by which A stretches or shrinks lengths.
double stretch(const Eigen::Matrix2d& A) {
  const double squares = A.squaredNorm();
  const double area = std::abs(A(0, 0) * A(1, 1) - A(0, 1) * A(1, 0));
  const double difference = std::sqrt(std::max(0.0, squares * squares - 4 * area * area));
  const double longest = std::sqrt((squares + difference) / 2);  // the singular values
  return std::max(longest, longest / area);
}

/// The position of the kept patch in the new image [px], near the position of the last image's
/// patch; in images without this search, that position itself. None if the patch no longer fits,
/// for example where edges occlude each other. None if its scale or slant differs from that of the
/// original corner: the corner is then another point, and its drift is unknown.
std::optional<Eigen::Vector2d> find_kept(const TrackingStep& step, const FrontendSettings& settings,
                                         const Followed& followed, PatchAnchor& anchor) {
  constexpr double kNearFollowed = 1.5;  // [px]
  const int now = step.past.count();
  const int age = now - anchor.image;
  if (age % kEvery != 0) return followed.pixel;
  FollowSettings alike = follow_settings_of(settings);
  alike.min_correlation = least_kept_correlation(settings, followed);
  // That image is still stored: a track is in every pushed image, and its anchor is replaced when
  // it is at most patch_frames old.
  const auto kept = find_again(
      step.past.at(anchor.image), step.now,
      {.from = anchor.pixel, .to = followed.pixel, .to_A_from = anchor.now_A_then}, alike);
  if (!kept || (kept->pixel - followed.pixel).norm() > kNearFollowed) return std::nullopt;
  const Eigen::Matrix2d now_A_first = kept->to_A_from * anchor.then_A_first;
  if (!(stretch(now_A_first) <= settings.max_stretch)) return std::nullopt;
  anchor.now_A_then = kept->to_A_from;
  if (age + kEvery > settings.patch_frames) {
    anchor = {.image = now, .pixel = kept->pixel, .then_A_first = now_A_first};
  }
  return kept->pixel;
}

/// The motion beyond the rotation [px/s] near a pixel of the last image, by tracks that were
/// followed: the mean of the nearest ones, weighted by their distance. Zero where there is none.
Eigen::Vector2d drift_near(const Eigen::Vector2d& pixel, std::span<const Pair> followed) {
  constexpr std::size_t kNeighbours = 4;
  struct Neighbour {
    double squared = std::numeric_limits<double>::infinity();  // distance [px^2]
    Eigen::Vector2d drift = Eigen::Vector2d::Zero();
  };
  std::array<Neighbour, kNeighbours> nearest;  // the nearest first
  for (const Pair& pair : followed) {
    Neighbour next{.squared = (pair.last.pixel - pixel).squaredNorm(), .drift = pair.now.drift};
    for (Neighbour& known : nearest) {
      if (next.squared < known.squared) std::swap(next, known);
    }
  }
  double weights = 0;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Neighbour& n : nearest) {
    const double weight = 1 / (1 + n.squared);
    weights += weight;
    sum += weight * n.drift;
  }
  return weights > 0 ? Eigen::Vector2d(sum / weights) : Eigen::Vector2d::Zero();
}

/// The track in the new image, `drift` [px/s] beyond the rotation expected; none if it ends, and
/// the reason is counted.
std::optional<Track> follow_track(const TrackingStep& step, const FrontendSettings& settings,
                                  const Track& last, const Eigen::Vector2d& drift,
                                  FrontendReport& report) {
  const auto turned =
      transfer(last.ray, 0, {step.now_R_last, Eigen::Vector3d::Zero()}, step.camera);
  if (!turned || !in_image(step.camera, turned->pixel)) {
    ++report.lost_left_image;
    return std::nullopt;
  }
  const FollowSettings follow_settings = follow_settings_of(settings);
  Expectation expected{.from = last.pixel,
                       .to = turned->pixel + drift * step.seconds,
                       .to_A_from = turned->to_A_from,
                       .levels = step.trusted ? settings.predicted_levels : settings.levels};
  if (!in_image(step.camera, expected.to)) expected.to = turned->pixel;
  Followed found = follow(step.past.last(), step.now, expected, follow_settings);
  if (found.outcome != FollowOutcome::kFound && expected.levels < settings.levels) {
    expected.to = turned->pixel;
    expected.levels = settings.levels;
    found = follow(step.past.last(), step.now, expected, follow_settings);
  }
  if (found.outcome != FollowOutcome::kFound) {
    ++(found.outcome == FollowOutcome::kFailed ? report.lost_klt : report.lost_backward);
    return std::nullopt;
  }
  PatchAnchor anchor = last.anchor;
  anchor.now_A_then = turned->to_A_from * anchor.now_A_then;
  if (settings.patch_frames >= kEvery) {
    const auto kept = find_kept(step, settings, found, anchor);
    if (!kept) {
      ++report.lost_changed;
      return std::nullopt;
    }
    found.pixel = *kept;
  }
  const auto ray = wide_ray(step.camera, found.pixel);
  if (!ray || !in_image(step.camera, found.pixel, settings.border)) {
    ++report.lost_left_image;
    return std::nullopt;
  }
  if (masked(step.mask, found.pixel)) {
    ++report.lost_masked;
    return std::nullopt;
  }
  Track now = last;
  now.pixel = found.pixel;
  now.anchor = anchor;
  now.ray = *ray;
  now.drift = (found.pixel - turned->pixel) / step.seconds;
  ++now.age;
  return now;
}

void reject_outliers(const TrackingStep& step, const FrontendSettings& settings,
                     std::vector<Pair>& pairs, FrontendReport& report) {
  std::vector<RayPair> rays;
  rays.reserve(pairs.size());
  for (const Pair& pair : pairs) {
    rays.push_back({.last = pair.last.ray.ray.normalized(), .now = pair.now.ray.ray.normalized()});
  }
  const double focal = std::sqrt(focal_lengths_at_axis(step.camera).prod());
  const TwoView motion =
      find_motion(rays, {.now_R_last = step.now_R_last,
                         .trusted = step.trusted,
                         .threshold = settings.outlier_threshold / focal,
                         .seed = static_cast<std::uint64_t>(report.time.count())});
  report.motion_decided = report.motion_decided || motion.decided;
  report.rotation_correction = std::max(
      report.rotation_correction, so3::log(motion.now_R_last * step.now_R_last.transpose()).norm());
  std::vector<Pair> right;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (motion.right[i]) right.push_back(pairs[i]);
  }
  report.lost_outlier += static_cast<int>(pairs.size() - right.size());
  pairs = std::move(right);
}

/// Of two tracks at the same position the younger ends; tracks are in the order of their ids.
void merge(std::vector<Track>& tracks, FrontendReport& report) {
  std::vector<Track> apart;
  for (Track& track : tracks) {
    const bool alone = std::none_of(apart.begin(), apart.end(), [&](const Track& older) {
      return (older.pixel - track.pixel).squaredNorm() < kMergeDistance * kMergeDistance;
    });
    if (alone) {
      apart.push_back(std::move(track));
    } else {
      ++report.lost_merged;
    }
  }
  tracks = std::move(apart);
}

/// Zero for an empty list.
double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double median_parallax(const std::vector<Track>& tracks, double seconds) {
  std::vector<double> lengths;
  for (const Track& track : tracks) lengths.push_back(track.drift.norm() * seconds);
  return median(std::move(lengths));
}

}  // namespace

FollowSettings follow_settings_of(const FrontendSettings& settings) {
  // The gradient of a patch may fall to a third of that required of a new corner before the track
  // ends.
  return {.window = settings.window,
          .min_correlation = settings.min_correlation,
          .max_backward_error = settings.max_backward_error,
          .min_gradient = settings.min_corner_gradient / 3};
}

void follow_tracks(const TrackingStep& step, const FrontendSettings& settings,
                   std::vector<Track>& tracks, FrontendReport& report) {
  StageClock clock;
  std::vector<Pair> pairs;
  pairs.reserve(tracks.size());
  const auto add = [&](const Track& last, const Eigen::Vector2d& drift) {
    std::optional<Track> now = follow_track(step, settings, last, drift, report);
    if (now) pairs.push_back({.last = last, .now = std::move(*now)});
  };
  // New tracks are the last ones, and have no drift of their own yet.
  for (const Track& last : tracks) {
    if (last.age > 1) add(last, last.drift);
  }
  const std::size_t known = pairs.size();
  for (const Track& last : tracks) {
    if (last.age == 1) add(last, drift_near(last.pixel, std::span(pairs).first(known)));
  }
  report.follow_seconds += clock.lap();
  if (settings.reject_outliers) reject_outliers(step, settings, pairs, report);
  tracks.clear();
  for (Pair& pair : pairs) tracks.push_back(std::move(pair.now));
  merge(tracks, report);
  report.outlier_seconds += clock.lap();
  report.tracked += static_cast<int>(tracks.size());
  report.median_parallax = std::max(report.median_parallax, median_parallax(tracks, step.seconds));
}

}  // namespace chasles
