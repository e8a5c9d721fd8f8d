#include <algorithm>
#include <cmath>

#include <chasles/slam/inertial_slam.hpp>

// What becomes of points that are not in the state: how they begin, and what they tell before.
namespace chasles {

// Begins one where there is none.
InertialSlam::Track& InertialSlam::track_of(LandmarkId id) {
  const auto place = std::ranges::lower_bound(tracks_, id, {}, &Track::id);
  if (place != tracks_.end() && place->id == id) return *place;
  Track& track = tracks_.insert(place);
  track.id = id;
  track.ended = false;
  track.views.clear();
  track.views.reserve(static_cast<std::size_t>(settings_.clones) * cameras_.size());
  return track;
}

void InertialSlam::forget_ended_tracks() {
  tracks_.remove_if([](const Track& track) { return track.ended; });
}

void InertialSlam::begin_at_once(const std::vector<const PixelObservation*>& fresh,
                                 InertialEstimate& e) {
  const bool anchored = settings_.landmarks == "inverse-depth";
  int room = settings_.max_landmarks - static_cast<int>(filter_.state().landmarks.size());
  std::vector<NewLandmark>& landmarks = work_.begun;
  landmarks.clear();
  for (const PixelObservation* o : fresh) {
    const Camera& camera = cameras_[static_cast<std::size_t>(o->camera)];
    const bool begun = std::any_of(landmarks.begin(), landmarks.end(),
                                   [&](const NewLandmark& l) { return l.id == o->landmark; });
    if (room <= 0 || begun) continue;
    if (anchored && landmarks.empty()) filter_.clone_pose(frame_, now_);
    const State& x = filter_.state();
    const auto landmark =
        anchored ? begin_anchored(camera, pixel_sigma_, x, o->landmark, o->pixel,
                                  settings_.inverse_depth, settings_.inverse_depth_sigma, o->camera)
                 : begin_at_depth(camera, pixel_sigma_, x, o->landmark, o->pixel,
                                  settings_.fixed_depth, settings_.fixed_depth_sigma, o->camera);
    if (!landmark) continue;
    landmarks.push_back(*landmark);
    last_.push_back({.seen = frame_});
    --room;
  }
  filter_.add(landmarks);
  e.added = static_cast<int>(landmarks.size());
}

bool InertialSlam::is_full() const {
  return static_cast<int>(filter_.state().landmarks.size()) >= settings_.max_landmarks;
}

void InertialSlam::begin_from_tracks(InertialEstimate& e) {
  for (Track& track : tracks_) {
    if (track.seen < frame_) {
      use_rest(track.id, track.views);
      track.ended = true;
    } else if (cloned_ && !is_full() && begin(track.id, track.views)) {
      track.ended = true;
      ++e.added;
    }
  }
  forget_ended_tracks();
  if (cloned_) begin_what_is_missing(e);
}

// Where there is hardly a landmark, as at the start or after a sharp turn, one cannot wait.
void InertialSlam::begin_what_is_missing(InertialEstimate& e) {
  int missing = settings_.min_landmarks - static_cast<int>(filter_.state().landmarks.size());
  std::vector<NewLandmark>& landmarks = work_.begun;
  landmarks.clear();
  for (Track& track : tracks_) {
    if (missing <= 0) break;
    if (track.views.empty() || track.views.back().clone != frame_) continue;
    const ClonedView& view = track.views.back();
    const auto landmark = begin_anchored(
        cameras_[static_cast<std::size_t>(view.camera)], pixel_sigma_, filter_.state(), track.id,
        view.pixel, settings_.inverse_depth, settings_.inverse_depth_sigma, view.camera);
    if (!landmark) continue;
    landmarks.push_back(*landmark);
    last_.push_back({.seen = frame_});
    track.ended = true;
    --missing;
  }
  forget_ended_tracks();
  filter_.add(landmarks);
  e.added += static_cast<int>(landmarks.size());
}

// Into work_.start.
bool InertialSlam::find_start(LandmarkId id, const Views& views) {
  constexpr std::size_t kLeastViews = 3;
  return views.size() >= kLeastViews &&
         begin_multi_view(cameras_, pixel_sigma_, filter_.state(), id, views,
                          settings_.landmarks == "inverse-depth", linearisation(), work_.multi_view,
                          work_.start);
}

// A landmark from a track, if its views tell where it is.
bool InertialSlam::begin(LandmarkId id, const Views& views) {
  if (!find_start(id, views)) return false;
  const MultiViewStart& start = work_.start;
  if (start.parallax < settings_.min_parallax ||
      std::sqrt(start.distance_noise) > settings_.max_relative_depth_sigma * start.distance ||
      relative_depth_sigma(start, filter_) > settings_.max_total_depth_sigma) {
    return false;
  }
  const double square = filter_.joint_normalised_square(start.rest);
  if (!(square < gate_square(start.rest_rows))) return false;
  filter_.add({&start.landmark, 1});
  filter_.update(start.rest);
  last_.push_back({.seen = frame_});
  return true;
}

// What a track that ends says of the poses that saw it; nothing where its point may be anywhere,
// for what is left when the point is taken out depends on where it is.
void InertialSlam::use_rest(LandmarkId id, const Views& views) {
  constexpr double kAnywhere = 1;  // deviation of the distance over the distance
  if (!find_start(id, views)) return;
  const MultiViewStart& start = work_.start;
  if (relative_depth_sigma(start, filter_) > kAnywhere) return;
  const double square = filter_.joint_normalised_square(start.rest);
  if (square < gate_square(start.rest_rows)) filter_.update(start.rest);
}

// The oldest clone of the window goes. What was seen from it begins now, or loses that view.
void InertialSlam::make_room_for_clone() {
  if (static_cast<int>(window_.size()) < settings_.clones) return;
  const int oldest = window_.front();
  window_.erase(window_.begin());
  for (Track& track : tracks_) {
    const auto is_oldest = [&](const ClonedView& view) { return view.clone == oldest; };
    if (std::none_of(track.views.begin(), track.views.end(), is_oldest)) continue;
    if (!is_full() && begin(track.id, track.views)) {
      track.ended = true;
    } else {
      use_rest(track.id, track.views);
      track.views.clear();
    }
  }
  forget_ended_tracks();
}

}  // namespace chasles
