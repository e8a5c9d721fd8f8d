#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include <chasles/base/stage_clock.hpp>
#include <chasles/camera/rig_overlap.hpp>
#include <chasles/frontend/camera_tracks.hpp>
#include <chasles/frontend/coverage.hpp>
#include <chasles/frontend/frontend.hpp>
#include <chasles/frontend/frontend_checks.hpp>
#include <chasles/frontend/image_pyramid.hpp>
#include <chasles/frontend/stereo_match.hpp>

namespace chasles {
namespace {

constexpr int kStereoPause = 4;  // frames, after a search along the epipolar curve found nothing

}  // namespace

struct Frontend::State {
  /// A finder and its tracks.
  struct FinderTracks {
    Finder finder;
    CameraTracks own;
  };

  FrontendSettings settings;
  std::vector<Camera> cameras;
  std::vector<GrayImage> masks;
  std::vector<FinderTracks> finders;

  FrontendReport report;
  std::optional<Time> last_frame = {};
  std::vector<ImagePyramid> now;  // one a camera
  std::vector<char> usable;       // whether `now` is of this frame; one a camera
  LandmarkId next_id = 0;

  bool is_usable(const FinderTracks& f) const { return usable[f.finder.camera] != 0; }
  void build_pyramid_of(const ImageFrame& frame, std::size_t camera);
  void build_pyramids(const ImageFrame& frame);
  void match_other(const StereoViews& views, std::size_t camera, Track& track);
  void match(FinderTracks& f, std::size_t first);
  std::vector<Eigen::Vector2d> matches_in(std::size_t camera) const;
  void end_doubles(FinderTracks& f);
  void add_tracks(FinderTracks& f);
  void process(Time time);
  void count();
  FeatureFrame features(Time time) const;
};

void Frontend::State::build_pyramid_of(const ImageFrame& frame, std::size_t camera) {
  if (frame.images[camera].empty()) {
    ++report.missing_images;
    return;
  }
  build_pyramid(frame.images[camera], settings.equalisation, settings.levels, now[camera]);
  const Exposure seen = exposure(now[camera]);
  usable[camera] = seen == Exposure::kUsable ? 1 : 0;
  if (seen == Exposure::kBlack) ++report.black_images;
  if (seen == Exposure::kSaturated) ++report.saturated_images;
}

// Of the finders, and of the cameras in which one with a usable image searches.
void Frontend::State::build_pyramids(const ImageFrame& frame) {
  StageClock clock;
  usable.assign(cameras.size(), 0);
  std::vector<char> finding(cameras.size(), 0), searched(cameras.size(), 0);
  for (const FinderTracks& f : finders) {
    finding[f.finder.camera] = 1;
    build_pyramid_of(frame, f.finder.camera);
    if (!settings.stereo || !is_usable(f)) continue;
    for (const std::size_t c : f.finder.searched) searched[c] = 1;
  }
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (searched[c] != 0 && finding[c] == 0) build_pyramid_of(frame, c);
  }
  report.pyramid_seconds = clock.lap();
}

void Frontend::State::match_other(const StereoViews& views, std::size_t camera, Track& track) {
  OtherView& other = track.others[camera];
  if (other.pause > 0) {
    --other.pause;
    return;
  }
  ++report.stereo_tried;
  const auto match = match_stereo(views, {track.pixel, track.ray, other.inverse_depth},
                                  {.follow = follow_settings_of(settings),
                                   .epipolar_threshold = settings.epipolar_threshold,
                                   .min_depth = settings.min_stereo_depth});
  if (match && !masked(masks[camera], match->pixel) &&
      in_image(cameras[camera], match->pixel, settings.border)) {
    ++report.stereo_matched;
    ++report.cameras[camera].matched;
    other.pixel = match->pixel;
    other.inverse_depth = match->inverse_depth;
  } else {
    other.inverse_depth.reset();
    other.pause = kStereoPause;
  }
}

// The tracks of a finder, from the first of these on, in the other cameras.
void Frontend::State::match(FinderTracks& f, std::size_t first) {
  if (!settings.stereo) return;
  StageClock clock;
  std::vector<Track>& tracks = f.own.tracks();
  for (const std::size_t c : f.finder.searched) {
    for (std::size_t i = first; i < tracks.size(); ++i) tracks[i].others[c].pixel.reset();
    if (usable[c] == 0) continue;
    const StereoViews views(cameras[f.finder.camera], now[f.finder.camera], cameras[c], now[c]);
    for (std::size_t i = first; i < tracks.size(); ++i) match_other(views, c, tracks[i]);
  }
  report.stereo_seconds += clock.lap();
}

std::vector<Eigen::Vector2d> Frontend::State::matches_in(std::size_t camera) const {
  std::vector<Eigen::Vector2d> pixels;
  for (const FinderTracks& f : finders) {
    if (!is_usable(f)) continue;
    for (const Track& track : f.own.tracks()) {
      const auto& seen = track.others[camera].pixel;
      if (seen) pixels.push_back(*seen);
    }
  }
  return pixels;
}

// Of two tracks of different finders that meet in the image of one of them, the younger would be
// the second track of the point.
void Frontend::State::end_doubles(FinderTracks& f) {
  const std::size_t camera = f.finder.camera;
  for (FinderTracks& other : finders) {
    if (&other == &f || !is_usable(other)) continue;
    const auto doubled = [&](const Track& own, const Track& from_other) {
      const auto& seen = from_other.others[camera].pixel;
      return seen && (*seen - own.pixel).squaredNorm() < kMergeDistance * kMergeDistance;
    };
    const auto end_younger = [&](std::vector<Track>& younger, auto&& meets) {
      const std::size_t ended = std::erase_if(younger, meets);
      report.lost_merged += static_cast<int>(ended);
      report.tracked -= static_cast<int>(ended);
    };
    end_younger(f.own.tracks(), [&](const Track& own) {
      return std::ranges::any_of(other.own.tracks(), [&](const Track& older) {
        return older.id < own.id && doubled(own, older);
      });
    });
    end_younger(other.own.tracks(), [&](const Track& from_other) {
      return std::ranges::any_of(f.own.tracks(), [&](const Track& older) {
        return older.id < from_other.id && doubled(older, from_other);
      });
    });
  }
}

void Frontend::State::add_tracks(FinderTracks& f) {
  const std::size_t camera = f.finder.camera;
  const std::size_t first = f.own.add(now[camera], matches_in(camera), next_id, report);
  report.cameras[camera].added = static_cast<int>(f.own.tracks().size() - first);
  match(f, first);
}

void Frontend::State::process(Time time) {
  for (FinderTracks& f : finders) {
    if (!is_usable(f)) continue;
    f.own.follow(now[f.finder.camera], time, report);
    match(f, 0);
  }
  for (FinderTracks& f : finders) {
    if (is_usable(f)) end_doubles(f);
  }
  for (FinderTracks& f : finders) {
    if (is_usable(f)) add_tracks(f);
  }
  count();
  for (FinderTracks& f : finders) {
    if (is_usable(f)) f.own.keep(now[f.finder.camera]);
  }
}

// Of the cameras with an image.
void Frontend::State::count() {
  std::vector<int> ages;
  for (const FinderTracks& f : finders) {
    if (!is_usable(f)) continue;
    report.cameras[f.finder.camera].found = static_cast<int>(f.own.tracks().size());
    for (const Track& track : f.own.tracks()) ages.push_back(track.age);
  }
  if (ages.empty()) return;
  std::sort(ages.begin(), ages.end());
  double sum = 0;
  for (const int age : ages) sum += age;
  report.mean_age = sum / static_cast<double>(ages.size());
  report.median_age = (ages[(ages.size() - 1) / 2] + ages[ages.size() / 2]) / 2.0;
}

FeatureFrame Frontend::State::features(Time time) const {
  FeatureFrame result{.time = time};
  for (const FinderTracks& f : finders) {
    if (!is_usable(f)) continue;
    for (const Track& track : f.own.tracks()) {
      for (std::size_t c = 0; c < cameras.size(); ++c) {
        const bool own = c == f.finder.camera;
        const auto seen = own ? std::optional(track.pixel) : track.others[c].pixel;
        if (!seen) continue;
        result.pixels.push_back(
            {.landmark = track.id, .camera = static_cast<int>(c), .match = !own, .pixel = *seen});
      }
    }
  }
  std::ranges::sort(result.pixels, {},
                    [](const PixelObservation& o) { return std::pair(o.camera, o.landmark); });
  return result;
}

Frontend::Frontend(const FrontendSettings& settings, std::vector<Camera> cameras,
                   std::vector<GrayImage> masks) {
  validate(settings);
  if (masks.empty()) masks.resize(cameras.size());
  check_rig(cameras, masks);
  const std::vector<Finder> roles = finders_of(cameras);
  const int share = tracks_per_finder(settings.max_tracks, roles.size());
  std::vector<State::FinderTracks> finders;
  for (const Finder& finder : roles) {
    const std::size_t c = finder.camera;
    finders.push_back({finder, {settings, cameras[c], masks[c], cameras.size(), share}});
  }
  state_ = std::make_unique<State>();
  state_->settings = settings;
  state_->now.resize(cameras.size());
  state_->cameras = std::move(cameras);
  state_->masks = std::move(masks);
  state_->finders = std::move(finders);
}

Frontend::~Frontend() = default;
Frontend::Frontend(Frontend&&) noexcept = default;
Frontend& Frontend::operator=(Frontend&&) noexcept = default;

const FrontendReport& Frontend::report() const { return state_->report; }

FeatureFrame Frontend::process(const ImageFrame& frame, const RotationPrior& rotation) {
  State& state = *state_;
  check_frame(frame, rotation, state.last_frame, state.cameras);
  state.report = {.time = frame.time};
  state.report.cameras.resize(state.cameras.size());
  state.last_frame = frame.time;
  state.build_pyramids(frame);
  for (State::FinderTracks& f : state.finders) {
    f.own.turn(rotation);
    f.own.end_after_gap(frame.time, state.report);
  }
  state.process(frame.time);
  return state.features(frame.time);
}

}  // namespace chasles
