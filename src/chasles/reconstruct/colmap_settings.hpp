#pragma once

#include <optional>

#include <chasles/base/settings.hpp>

namespace chasles {

/// Settings of a model for COLMAP: which images become keyframes, and which tracks points. The list
/// below defines --set and its help.
struct ColmapSettings {
  double rotation = 10;
  std::optional<double> distance = {};
  double overlap = 0.7;
  double search = 0.5;
  double min_sharpness = 0.5;

  int min_observations = 3;
  double min_parallax = 1;
  double max_error = 2;
};

/// Calls visit(name, value, unit, meaning, limits) for every setting, in order.
template <SettingsOf<ColmapSettings> S, typename Visitor>
void for_each_setting(S& s, Visitor&& visit) {
  visit("rotation", s.rotation, "deg", "a keyframe is due after this rotation since the last one",
        limits::from_to(0.001, 180));
  visit("distance", s.distance, "m", "and after this distance; auto: no limit", limits::kPositive);
  visit("overlap", s.overlap, "1",
        "and when the frame has less than this part of the last keyframe's tracks",
        limits::from_to(0, 0.999));
  visit(
      "search", s.search, "1",
      "the sharpest frame becomes the keyframe, among that which is due and those up to this part "
      "of the spacing after it",
      limits::from_to(0, 10));
  visit("min_sharpness", s.min_sharpness, "1",
        "a frame less sharp than this part of the median of its ten neighbours is no keyframe",
        limits::from_to(0, 1));
  visit("min_observations", s.min_observations, "count",
        "of a track in the images of keyframes; below, it is no point", limits::from_to(2, 1000));
  visit("min_parallax", s.min_parallax, "deg",
        "largest angle between two rays of a track; below, it is no point",
        limits::from_to(0.001, 180));
  visit("max_error", s.max_error, "px",
        "mean length of a point's reprojection errors; above, it is left out", limits::kPositive);
}

}  // namespace chasles
