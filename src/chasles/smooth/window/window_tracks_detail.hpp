#pragma once

#include <algorithm>
#include <map>
#include <optional>

#include <chasles/smooth/terms/cost_functions_detail.hpp>
#include <chasles/smooth/window/window_run_detail.hpp>

/// The views that a window's landmarks have or may begin with: for this folder's sources alone.
namespace chasles::smooth_detail {

/// `Point`: a landmark with its views, as the batch has it.
template <typename Point>
class WindowTracks {
 public:
  struct Track {
    Point of;                       ///< views of keyframes of the window
    std::optional<int> point = {};  ///< its number in the window, once it has begun
  };

  Track& of(LandmarkId id) {
    Track& track = tracks_[id];
    track.of.id = id;
    return track;
  }
  void begin(Track& track, int point) {
    track.point = point;
    id_of_[point] = track.of.id;
  }

  /// After keyframes have left. The views of landmarks that left with them have been used; those of
  /// others that are older than the window have not, and will not be.
  void forget(const Window& window) {
    std::erase_if(id_of_, [&](const auto& entry) {
      if (window.points.contains(entry.first)) return false;
      if (with(entry.first) != nullptr) tracks_.erase(entry.second);
      return true;
    });
    const auto has_left = [&](const auto& view) { return view.keyframe < window.first; };
    for (auto& [id, track] : tracks_) std::erase_if(track.of.views, has_left);
    std::erase_if(tracks_, [](const auto& entry) {
      return entry.second.of.views.empty() && !entry.second.point;
    });
  }

  /// After the gate: a landmark that went may begin anew with the views that agreed.
  void forget(const Culled& culled, WindowReport& report) {
    report.gated += static_cast<int>(culled.views.size());
    report.observations -= static_cast<int>(culled.views.size());
    for (const CulledView& gone : culled.views) {
      if (Track* track = with(gone.point)) {
        std::erase_if(track->of.views, [&](const auto& view) { return is(view, gone); });
      }
    }
    for (const int number : culled.points) {
      if (Track* track = with(number)) {
        report.observations -= static_cast<int>(track->of.views.size());
        track->point.reset();
      }
      id_of_.erase(number);
      --report.landmarks;
    }
  }

 private:
  template <typename View>
  static bool is(const View& view, const CulledView& gone) {
    if constexpr (requires { view.camera; }) {
      if (view.camera != gone.camera) return false;
    }
    return view.keyframe == gone.keyframe;
  }

  // Null where the landmark has come back as another.
  Track* with(int point) {
    const auto track = tracks_.find(id_of_.at(point));
    return track != tracks_.end() && track->second.point == point ? &track->second : nullptr;
  }

  std::map<LandmarkId, Track> tracks_;
  std::map<int, LandmarkId> id_of_;  // by number of the point
};

/// A view's costs in all the forms that the landmark may have.
template <typename Term>
WindowView window_view(const Term& term, bool anchored) {
  WindowView view;
  if (anchored) {
    view.cost = std::make_unique<AnchoredCost<Term>>(term);
    view.at_anchor = std::make_unique<AnchorCost<Term>>(term);
  } else {
    view.cost = std::make_unique<PointCost<Term>>(term);
  }
  return view;
}

}  // namespace chasles::smooth_detail
