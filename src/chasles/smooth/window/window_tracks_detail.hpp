#pragma once

#include <algorithm>
#include <map>
#include <optional>

#include <chasles/smooth/terms/calibrated_costs_detail.hpp>
#include <chasles/smooth/terms/cost_functions_detail.hpp>
#include <chasles/smooth/window/window_run_detail.hpp>

/// The views of a window's landmarks and of tracks that may become landmarks. Private to this
/// folder.
namespace chasles::smooth_detail {

/// `Point`: a landmark with its views, as in the batch.
template <typename Point>
class WindowTracks {
 public:
  struct Track {
    Point of;                       ///< views from keyframes of the window
    std::optional<int> point = {};  ///< its number in the window, once it is initialised
    int matches = 0;                ///< of the landmark, also in keyframes that have left
  };

  Track& of(LandmarkId id) {
    Track& track = tracks_[id];
    track.of.id = id;
    return track;
  }
  void initialise(Track& track, int point) {
    track.point = point;
    id_of_[point] = track.of.id;
  }

  /// Call after keyframes were marginalised. The views of landmarks that left with them have been
  /// used. Views of other tracks from older keyframes are removed unused.
  void drop(const Window& window) {
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

  /// Call after the gate: a removed landmark may be initialised again with the views that agreed.
  void drop(const Culled& culled, WindowReport& report) {
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

  // Null where the landmark has returned as another one.
  Track* with(int point) {
    const auto track = tracks_.find(id_of_.at(point));
    return track != tracks_.end() && track->second.point == point ? &track->second : nullptr;
  }

  std::map<LandmarkId, Track> tracks_;
  std::map<int, LandmarkId> id_of_;  // by number of the point
};

/// The costs of a view in all forms of the landmark.
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

/// A pixel of a known camera.
inline WindowView window_view(const PixelTerm& term, bool /*anchored*/) {
  WindowView view;
  view.pixel = term;
  return view;
}

/// The same where the calibration is estimated.
inline WindowView window_view(const CalibratedTerm& term, bool anchored) {
  WindowView view;
  if (anchored) {
    view.cost = std::make_unique<CalibratedCost>(term, ViewForm::kAnchored);
    view.at_anchor = std::make_unique<CalibratedCost>(term, ViewForm::kAnchor);
  } else {
    view.cost = std::make_unique<CalibratedCost>(term, ViewForm::kPoint);
  }
  return view;
}

}  // namespace chasles::smooth_detail
