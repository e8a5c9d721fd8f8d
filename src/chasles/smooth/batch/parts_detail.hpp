#pragma once

#include <span>
#include <utility>
#include <vector>

#include <chasles/smooth/batch/batch.hpp>

/// The effect of the gate on a landmark. Private to this folder.
namespace chasles::smooth_detail {

/// Those of a landmark's views (sorted by `keyframe`) whose `whitened_norms` (residual in standard
/// deviations) are at most `gate`. They are split where the landmark was rejected in
/// `max_rejections` consecutive keyframes that observed it: a track that has drifted for so long is
/// another point when it agrees again. 0: never split. Returns at least one part, which may be
/// empty.
template <typename View>
std::vector<std::vector<View>> parts_that_agree(const std::vector<View>& views,
                                                std::span<const double> whitened_norms, double gate,
                                                int max_rejections) {
  std::vector<std::vector<View>> parts(1);
  int rejected = 0;         // consecutive keyframes before the present one
  bool agreed_now = false;  // in the present one, by any camera
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (i > 0 && views[i].keyframe != views[i - 1].keyframe) {
      rejected = agreed_now ? 0 : rejected + 1;
      agreed_now = false;
    }
    if (!(whitened_norms[i] <= gate)) continue;  // written so that a NaN is rejected
    const bool another = max_rejections > 0 && rejected >= max_rejections && !agreed_now;
    if (another && !parts.back().empty()) parts.emplace_back();
    parts.back().push_back(views[i]);
    agreed_now = true;
  }
  return parts;
}

/// Reduces all landmarks to the parts that agree and that are still landmarks. `stands(whole,
/// split, part)` places a part and returns whether it is one; `use(view)` is called for every
/// remaining view. `whitened_norms`: of all views, in order. Counts into the report; returns the
/// number of removed views.
template <typename Point, typename Stands, typename Use>
int keep_what_agrees(std::vector<Point>& points, std::span<const double> whitened_norms,
                     double gate, int max_rejections, BatchReport& report, const Stands& stands,
                     const Use& use) {
  std::vector<Point> kept;
  int gone = 0;
  for (const Point& point : points) {
    int stood = 0, left = 0;
    auto parts = parts_that_agree(point.views, whitened_norms, gate, max_rejections);
    for (auto& views : parts) {
      Point part{.id = point.id, .views = std::move(views), .parameters = point.parameters};
      if (!stands(point, parts.size() > 1, part)) continue;
      ++stood;
      left += static_cast<int>(part.views.size());
      for (const auto& view : part.views) use(view);
      kept.push_back(std::move(part));
    }
    if (stood == 0) ++report.landmarks_left_out;
    if (stood > 1) report.landmarks_split += stood - 1;
    gone += static_cast<int>(point.views.size()) - left;
    whitened_norms = whitened_norms.subspan(point.views.size());
  }
  points = std::move(kept);
  report.gated += gone;
  report.observations -= gone;
  report.landmarks = static_cast<int>(points.size());
  return gone;
}

}  // namespace chasles::smooth_detail
