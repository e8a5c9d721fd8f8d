#include <algorithm>
#include <cmath>

#include <chasles/slam/inertial_slam.hpp>

// Points that are not in the state: landmark initialisation and null-space updates.
namespace chasles {

// Adds a new track if there is none.
InertialSlam::Track& InertialSlam::track_of(LandmarkId id) {
  const auto place = std::ranges::lower_bound(tracks_, id, {}, &Track::id);
  if (place != tracks_.end() && place->id == id) return *place;
  Track& track = tracks_.insert(place);
  track.id = id;
  track.cameras = 0;
  track.ended = false;
  track.views.clear();
  track.views.reserve(static_cast<std::size_t>(settings_.clones) * cameras_.size());
  return track;
}

void InertialSlam::remove_ended_tracks() {
  tracks_.remove_if([](const Track& track) { return track.ended; });
}

// At an assumed depth.
std::optional<NewLandmark> InertialSlam::initialise_undelayed(LandmarkId id, int camera_index,
                                                              const Eigen::Vector2d& pixel,
                                                              bool anchored) const {
  const Camera& camera = cameras_[static_cast<std::size_t>(camera_index)];
  const State& x = filter_.state();
  AssumedDepth depth{
      .mean = anchored ? settings_.inverse_depth : settings_.fixed_depth,
      .sigma = anchored ? settings_.inverse_depth_sigma : settings_.fixed_depth_sigma};
  if (depth_rule_) {
    const auto own = depth_rule_({.state = x,
                                  .camera = camera,
                                  .camera_index = camera_index,
                                  .pixel = pixel,
                                  .inverse = anchored});
    if (!own) return std::nullopt;
    depth = *own;
  }
  const auto initialise = anchored ? initialise_anchored : initialise_at_depth;
  return initialise(camera, track_noise().sigma, x, id, pixel, depth.mean, depth.sigma,
                    camera_index);
}

void InertialSlam::initialise_fresh(const std::vector<const PixelObservation*>& fresh,
                                    Estimate& e) {
  const bool anchored = settings_.landmarks == LandmarkForm::kInverseDepth;
  int room = settings_.max_landmarks - static_cast<int>(filter_.state().landmarks.size());
  Reused<NewLandmark>& landmarks = work_.initialised;
  landmarks.clear();
  for (const PixelObservation* o : fresh) {
    const bool initialised = std::any_of(landmarks.begin(), landmarks.end(),
                                         [&](const NewLandmark& l) { return l.id == o->landmark; });
    if (room <= 0 || initialised) continue;
    if (anchored && landmarks.empty()) keep_pose(now_);
    const auto landmark = initialise_undelayed(o->landmark, o->camera, o->pixel, anchored);
    if (!landmark) continue;
    landmarks.append() = *landmark;
    --room;
  }
  add_initialised(e);
}

// For the landmarks that this frame initialises and one more.
bool InertialSlam::has_room() const {
  const auto there = filter_.state().landmarks.size() + work_.initialised.size();
  return static_cast<int>(there) < settings_.max_landmarks;
}

bool InertialSlam::has_view(const Track& track, int clone) {
  return std::any_of(track.views.begin(), track.views.end(),
                     [&](const ClonedView& view) { return view.clone == clone; });
}

void InertialSlam::add_initialised(Estimate& e) {
  const Reused<NewLandmark>& landmarks = work_.initialised;
  filter_.add(landmarks);
  for (const NewLandmark& landmark : landmarks) {
    last_.push_back({.seen = frame_, .matches = landmark.matches});
  }
  e.added += static_cast<int>(landmarks.size());
  work_.initialised.clear();
}

// Adds the initialised landmarks to the filter, then updates it with the projected residuals.
void InertialSlam::null_space_update(Estimate& e) {
  add_initialised(e);
  filter_.update(work_.null_space);
  work_.null_space.clear();
}

// Many tracks are processed in one update, which costs less than one by one. But not all at once:
// later ones are linearised at a better state, which matters where the window of a start's tracks
// ends.
void InertialSlam::initialise_from_tracks(CameraSet observers, Estimate& e) {
  const bool full = static_cast<int>(window_.size()) >= settings_.clones;
  const auto many = static_cast<std::size_t>(2 * settings_.clones);  // twice the rows of the clones
  for (Track& track : tracks_) {
    const bool seen = track.seen == frame_;
    const bool lost = !seen && (track.cameras & observers) != 0;
    const bool last_chance = lost || (cloned_ && full && has_view(track, window_.front()));
    const bool may_initialise = seen && cloned_ && has_room();
    if (!last_chance && !may_initialise) continue;
    const bool found = find_start(track.id, track.views);
    if (found && may_initialise && is_certain(work_.start) && take_null_space(work_.start)) {
      work_.initialised.append() = work_.start.landmark;
      track.ended = true;
    } else if (last_chance) {
      if (found && is_somewhere(work_.start)) {
        const bool accepted = take_null_space(work_.start);
        if (recent_tracks_) recent_tracks_->note(accepted);
      }
      track.views.clear();
      track.ended = lost;
    }
    if (work_.null_space.size() >= many) null_space_update(e);
  }
  null_space_update(e);
  remove_ended_tracks();
  if (!cloned_) return;
  if (full) window_.erase(window_.begin());
  if (!e.zero_velocity) initialise_missing(e);
}

// With few landmarks, as at the start or after a sharp turn, tracks are initialised without delay.
void InertialSlam::initialise_missing(Estimate& e) {
  int missing = settings_.min_landmarks - static_cast<int>(filter_.state().landmarks.size());
  Reused<NewLandmark>& landmarks = work_.initialised;
  for (Track& track : tracks_) {
    if (missing <= 0) break;
    if (track.views.empty() || track.views.back().clone != frame_) continue;
    const ClonedView& view = track.views.back();
    const auto landmark = initialise_undelayed(track.id, view.camera, view.pixel, true);
    if (!landmark) continue;
    landmarks.append() = *landmark;
    track.ended = true;
    --missing;
  }
  remove_ended_tracks();
  add_initialised(e);
}

TrackUse InertialSlam::use_of_tracks() {
  if (!recent_tracks_) return {};
  return recent_tracks_->end_frame(static_cast<int>(std::ranges::count_if(
      tracks_, [&](const Track& t) { return t.seen == frame_ && t.views.size() >= 2; })));
}

// Writes work_.start.
bool InertialSlam::find_start(LandmarkId id, const Views& views) {
  constexpr std::size_t kLeastViews = 3;
  return views.size() >= kLeastViews &&
         initialise_multi_view(cameras_, track_noise(), filter_.state(), id, views,
                               settings_.landmarks == LandmarkForm::kInverseDepth, linearisation(),
                               work_.multi_view, work_.start);
}

// Whether the views determine the point well enough for a landmark.
bool InertialSlam::is_certain(const MultiViewStart& start) const {
  return start.parallax >= settings_.min_parallax &&
         std::sqrt(start.distance_noise) <= settings_.max_relative_depth_sigma * start.distance &&
         relative_depth_sigma(start, filter_) <= settings_.max_total_depth_sigma;
}

// If the position of the point is almost unknown, its track has no usable information: the
// projected residual depends on the linearisation point.
bool InertialSlam::is_somewhere(const MultiViewStart& start) const {
  constexpr double kAnywhere = 1;  // standard deviation of the distance over the distance
  return relative_depth_sigma(start, filter_) <= kAnywhere;
}

// Adds the projected residual of the views to those of this frame, if it passes the gate.
bool InertialSlam::take_null_space(const MultiViewStart& start) {
  const double square = filter_.joint_normalised_square(start.null_space);
  if (!(square < gate_square(start.null_space_rows))) return false;
  for (const Measurement& z : start.null_space) work_.null_space.append() = z;
  return true;
}

}  // namespace chasles
