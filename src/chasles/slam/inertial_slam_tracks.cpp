#include <algorithm>
#include <cmath>

#include <chasles/slam/inertial_slam.hpp>

// What becomes of points that are not in the state: how they begin, and what they tell before.
namespace chasles {

void InertialSlam::begin_at_once(const std::vector<const PixelObservation*>& fresh,
                                 InertialEstimate& e) {
  const bool anchored = settings_.landmarks == "inverse-depth";
  int room = settings_.max_landmarks - static_cast<int>(filter_.state().landmarks.size());
  std::vector<NewLandmark> landmarks;
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
    last_[o->landmark] = {.seen = frame_};
    --room;
  }
  filter_.add(landmarks);
  e.added = static_cast<int>(landmarks.size());
}

bool InertialSlam::is_full() const {
  return static_cast<int>(filter_.state().landmarks.size()) >= settings_.max_landmarks;
}

void InertialSlam::begin_from_tracks(InertialEstimate& e) {
  std::vector<LandmarkId>& ended = work_.ended;
  ended.clear();
  for (auto& [id, track] : tracks_) {
    if (track.seen < frame_) {
      use_rest(id, track.views);
      ended.push_back(id);
    } else if (cloned_ && !is_full() && begin(id, track.views)) {
      ended.push_back(id);
      ++e.added;
    }
  }
  for (const LandmarkId id : ended) tracks_.erase(id);
  if (cloned_) begin_what_is_missing(e);
}

// Where there is hardly a landmark, as at the start or after a sharp turn, one cannot wait.
void InertialSlam::begin_what_is_missing(InertialEstimate& e) {
  int missing = settings_.min_landmarks - static_cast<int>(filter_.state().landmarks.size());
  std::vector<NewLandmark> landmarks;
  for (const auto& [id, track] : tracks_) {
    if (missing <= 0) break;
    if (track.views.empty() || track.views.back().clone != frame_) continue;
    const ClonedView& view = track.views.back();
    const auto landmark = begin_anchored(
        cameras_[static_cast<std::size_t>(view.camera)], pixel_sigma_, filter_.state(), id,
        view.pixel, settings_.inverse_depth, settings_.inverse_depth_sigma, view.camera);
    if (!landmark) continue;
    landmarks.push_back(*landmark);
    last_[id] = {.seen = frame_};
    --missing;
  }
  for (const NewLandmark& landmark : landmarks) tracks_.erase(landmark.id);
  filter_.add(landmarks);
  e.added += static_cast<int>(landmarks.size());
}

// A landmark from a track, if its views tell where it is.
bool InertialSlam::begin(LandmarkId id, const Views& views) {
  if (views.size() < 3) return false;
  const auto start = begin_multi_view(cameras_, pixel_sigma_, filter_.state(), id, views,
                                      settings_.landmarks == "inverse-depth", linearisation());
  if (!start || start->parallax < settings_.min_parallax ||
      std::sqrt(start->distance_noise) > settings_.max_relative_depth_sigma * start->distance ||
      relative_depth_sigma(*start, filter_) > settings_.max_total_depth_sigma) {
    return false;
  }
  const double square = filter_.joint_normalised_square(start->rest);
  if (!(square < gate_square(start->rest_rows))) return false;
  filter_.add({&start->landmark, 1});
  filter_.update(start->rest);
  last_[id] = {.seen = frame_};
  return true;
}

// What a track that ends says of the poses that saw it; nothing where its point may be anywhere,
// for what is left when the point is taken out depends on where it is.
void InertialSlam::use_rest(LandmarkId id, const Views& views) {
  if (views.size() < 3) return;
  const auto start = begin_multi_view(cameras_, pixel_sigma_, filter_.state(), id, views,
                                      settings_.landmarks == "inverse-depth", linearisation());
  constexpr double kAnywhere = 1;  // deviation of the distance over the distance
  if (!start || relative_depth_sigma(*start, filter_) > kAnywhere) return;
  const double square = filter_.joint_normalised_square(start->rest);
  if (square < gate_square(start->rest_rows)) filter_.update(start->rest);
}

// The oldest clone of the window goes. What was seen from it begins now, or loses that view.
void InertialSlam::make_room_for_clone() {
  if (static_cast<int>(window_.size()) < settings_.clones) return;
  const int oldest = window_.front();
  window_.pop_front();
  std::vector<LandmarkId> begun;
  for (auto& [id, track] : tracks_) {
    const auto is_oldest = [&](const ClonedView& view) { return view.clone == oldest; };
    if (std::none_of(track.views.begin(), track.views.end(), is_oldest)) continue;
    if (!is_full() && begin(id, track.views)) {
      begun.push_back(id);
    } else {
      use_rest(id, track.views);
      track.views.clear();
    }
  }
  for (const LandmarkId id : begun) tracks_.erase(id);
}

}  // namespace chasles
