#include <algorithm>
#include <cmath>

#include <chasles/slam/track_updater.hpp>

namespace chasles {
namespace {

// With at most this many landmarks in its state, a filter works mainly with tracks.
constexpr int kFewLandmarks = 4;

std::optional<RecentTracks> recent_tracks(const InertialSlamSettings& s) {
  if (s.init != LandmarkInit::kMultiView ||
      std::max(s.max_landmarks, s.min_landmarks) >= kFewLandmarks) {
    return std::nullopt;
  }
  return RecentTracks(s.frames_per_clone, (s.clones + 1) * s.frames_per_clone);
}

bool has_view(const WaitingTrack& track, int clone) {
  return std::any_of(track.views.begin(), track.views.end(),
                     [&](const ClonedView& view) { return view.clone == clone; });
}

}  // namespace

TrackUpdater::TrackUpdater(const InertialSlamSettings& settings)
    : recent_(recent_tracks(settings)) {}

void TrackUpdater::add(const SlamContext& x, const PixelObservation& o, bool augmented) {
  WaitingTrack& track = track_of(x, o.landmark);
  track.seen = x.frame;
  track.cameras |= following(o);
  if (!augmented) return;
  track.views.push_back(
      {.clone = x.frame, .camera = o.camera, .pixel = o.pixel, .match = o.is_match()});
}

// Adds a new track if there is none.
WaitingTrack& TrackUpdater::track_of(const SlamContext& x, LandmarkId id) {
  const auto place = std::ranges::lower_bound(tracks_, id, {}, &WaitingTrack::id);
  if (place != tracks_.end() && place->id == id) return *place;
  WaitingTrack& track = tracks_.insert(place);
  track.id = id;
  track.cameras = 0;
  track.ended = false;
  track.views.clear();
  track.views.reserve(static_cast<std::size_t>(x.settings.clones) * x.cameras.size());
  return track;
}

void TrackUpdater::remove_ended() {
  tracks_.remove_if([](const WaitingTrack& track) { return track.ended; });
}

// For the landmarks that this frame initialises and one more.
bool TrackUpdater::has_room(const SlamContext& x) const {
  const auto there = x.state().landmarks.size() + landmarks_.size();
  return static_cast<int>(there) < x.settings.max_landmarks;
}

// Adds the initialised landmarks to the filter, then updates it with the projected residuals.
int TrackUpdater::add_and_update(SlamContext& x) {
  const int added = x.add(landmarks_);
  landmarks_.clear();
  x.filter.update(projected_);
  projected_.clear();
  return added;
}

// Many tracks are processed in one update, which costs less than one by one. But not all at once:
// later ones are linearised at a better state, which matters where the window of a start's tracks
// ends.
int TrackUpdater::update(SlamContext& x, CameraSet looking, const CloneWindow& clones) {
  const bool augmented = clones.augmented(), full = clones.full(x.settings);
  const auto many = static_cast<std::size_t>(2 * x.settings.clones);  // twice the clones' rows
  int added = 0;
  for (WaitingTrack& track : tracks_) {
    const bool seen = track.seen == x.frame;
    const bool lost = !seen && is_followed(track.cameras, looking);
    const bool last_chance = lost || (augmented && full && has_view(track, clones.oldest()));
    const bool may_initialise = seen && augmented && has_room(x);
    if (!last_chance && !may_initialise) continue;
    const bool found = find_start(x, track);
    if (found && may_initialise && is_certain(x) && take_projected(x)) {
      landmarks_.append() = start_.landmark;
      track.ended = true;
    } else if (last_chance) {
      if (found && is_somewhere(x)) {
        const bool accepted = take_projected(x);
        if (recent_) recent_->note(accepted);
      }
      track.views.clear();
      track.ended = lost;
    }
    if (projected_.size() >= many) added += add_and_update(x);
  }
  added += add_and_update(x);
  remove_ended();
  return added;
}

int TrackUpdater::initialise_missing(SlamContext& x, const UndelayedInitialiser& initialiser) {
  int missing = x.settings.min_landmarks - static_cast<int>(x.state().landmarks.size());
  for (WaitingTrack& track : tracks_) {
    if (missing <= 0) break;
    if (track.views.empty() || track.views.back().clone != x.frame) continue;
    const ClonedView& view = track.views.back();
    const auto landmark = initialiser.landmark(x, track.id, view.camera, view.pixel, true);
    if (!landmark) continue;
    landmarks_.append() = *landmark;
    track.ended = true;
    --missing;
  }
  remove_ended();
  const int added = x.add(landmarks_);
  landmarks_.clear();
  return added;
}

TrackUse TrackUpdater::use(const SlamContext& x) {
  if (!recent_) return {};
  return recent_->end_frame(static_cast<int>(std::ranges::count_if(
      tracks_, [&](const WaitingTrack& t) { return t.seen == x.frame && t.views.size() >= 2; })));
}

// Writes start_.
bool TrackUpdater::find_start(const SlamContext& x, const WaitingTrack& track) {
  constexpr std::size_t kLeastViews = 3;
  return track.views.size() >= kLeastViews &&
         initialise_multi_view(x.cameras, x.track_noise(), x.state(), track.id, track.views,
                               x.settings.landmarks == LandmarkForm::kInverseDepth,
                               x.linearisation(), scratch_, start_);
}

// Whether the views determine the point well enough for a landmark.
bool TrackUpdater::is_certain(const SlamContext& x) const {
  const InertialSlamSettings& s = x.settings;
  return start_.parallax >= s.min_parallax &&
         std::sqrt(start_.distance_noise) <= s.max_relative_depth_sigma * start_.distance &&
         relative_depth_sigma(start_, x.filter) <= s.max_total_depth_sigma;
}

// If the position of the point is almost unknown, its track has no usable information: the
// projected residual depends on the linearisation point.
bool TrackUpdater::is_somewhere(const SlamContext& x) const {
  constexpr double kAnywhere = 1;  // standard deviation of the distance over the distance
  return relative_depth_sigma(start_, x.filter) <= kAnywhere;
}

// Adds the projected residual of the views to those of this frame, if it passes the gate.
bool TrackUpdater::take_projected(const SlamContext& x) {
  const double square = x.filter.joint_normalised_square(start_.null_space);
  if (!(square < x.gate_square(start_.null_space_rows))) return false;
  for (const Measurement& z : start_.null_space) projected_.append() = z;
  return true;
}

}  // namespace chasles
