#pragma once

#include <span>
#include <utility>
#include <vector>

#include <chasles/smooth/batch/batch.hpp>

/// What the gate makes of a landmark: for this folder's sources alone.
namespace chasles::smooth_detail {

/// Those of a landmark's views (`keyframe` rising) whose deviations (residual over noise) are at
/// most `gate`, parted where the landmark was refused in `max_rejections` keyframes in a row that
/// saw it: a track that has slid off for so long is another point when it agrees again. 0: in one
/// part. At least one part, which may be empty.
template <typename View>
std::vector<std::vector<View>> parts_that_agree(const std::vector<View>& views,
                                                std::span<const double> deviations, double gate,
                                                int max_rejections) {
  std::vector<std::vector<View>> parts(1);
  int refused = 0;          // keyframes in a row before the present one
  bool agreed_now = false;  // in the present one, by any camera
  for (std::size_t i = 0; i < views.size(); ++i) {
    if (i > 0 && views[i].keyframe != views[i - 1].keyframe) {
      refused = agreed_now ? 0 : refused + 1;
      agreed_now = false;
    }
    if (!(deviations[i] <= gate)) continue;  // written so that a NaN is refused
    const bool another = max_rejections > 0 && refused >= max_rejections && !agreed_now;
    if (another && !parts.back().empty()) parts.emplace_back();
    parts.back().push_back(views[i]);
    agreed_now = true;
  }
  return parts;
}

/// Leaves of all landmarks the parts that agree and of which `stands(whole, parted, part)` says,
/// after it has placed them, that they are landmarks still; `use(view)` hears of all that is left
/// of the views. `deviations`: of all views, in order. Counts into the report; returns how many
/// views went.
template <typename Point, typename Stands, typename Use>
int keep_what_agrees(std::vector<Point>& points, std::span<const double> deviations, double gate,
                     int max_rejections, BatchReport& report, const Stands& stands,
                     const Use& use) {
  std::vector<Point> kept;
  int gone = 0;
  for (const Point& point : points) {
    int stood = 0, left = 0;
    auto parts = parts_that_agree(point.views, deviations, gate, max_rejections);
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
    deviations = deviations.subspan(point.views.size());
  }
  points = std::move(kept);
  report.gated += gone;
  report.observations -= gone;
  report.landmarks = static_cast<int>(points.size());
  return gone;
}

}  // namespace chasles::smooth_detail
