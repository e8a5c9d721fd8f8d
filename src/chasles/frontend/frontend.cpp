#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include <chasles/base/stage_clock.hpp>
#include <chasles/frontend/coverage.hpp>
#include <chasles/frontend/frontend.hpp>
#include <chasles/frontend/frontend_checks.hpp>
#include <chasles/frontend/image_pyramid.hpp>
#include <chasles/frontend/stereo_match.hpp>
#include <chasles/frontend/tracks.hpp>

namespace chasles {
namespace {

constexpr int kStereoPause = 4;  // frames, after a search along the epipolar curve found nothing

CoverageSettings coverage_settings_of(const FrontendSettings& s) {
  return {.measure = s.corners,
          .max_tracks = s.max_tracks,
          .columns = s.grid_columns,
          .rows = s.grid_rows,
          .cells_per_search = s.cells_per_frame,
          .min_distance = s.min_distance,
          .border = s.border,
          .min_gradient = s.min_corner_gradient};
}

}  // namespace

struct Frontend::State {
  FrontendSettings settings;
  std::vector<Camera> cameras;
  std::vector<GrayImage> masks;
  Coverage coverage;

  FrontendReport report;
  std::optional<Time> last_frame = {};  // of any frame
  Time last_image{};                    // of the last one in `past`
  PastImages past;                      // of camera 0, up to the previous one
  std::vector<ImagePyramid> now;        // one a camera
  std::vector<Track> tracks = {};
  LandmarkId next_id = 0;
  Eigen::Matrix3d now_R_last_imu = Eigen::Matrix3d::Identity();  // since that image
  bool rotation_trusted = true;

  std::vector<char> build_pyramids(const ImageFrame& frame);
  void end_after_gap(Time time);
  void follow(Time time);
  void add_tracks();
  void match_others(std::size_t camera);
  void match_other(const StereoViews& views, std::size_t camera, Track& track);
  void age_statistics();
  FeatureFrame features(Time time) const;
};

/// The cameras that have a usable image.
std::vector<char> Frontend::State::build_pyramids(const ImageFrame& frame) {
  StageClock clock;
  std::vector<char> usable(cameras.size(), 0);
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (i > 0 && (!settings.stereo || !usable[0])) break;
    if (frame.images[i].empty()) {
      ++report.missing_images;
      continue;
    }
    build_pyramid(frame.images[i], settings.equalisation, settings.levels, now[i]);
    const Exposure seen = exposure(now[i]);
    usable[i] = seen == Exposure::kUsable ? 1 : 0;
    if (seen == Exposure::kBlack) ++report.black_images;
    if (seen == Exposure::kSaturated) ++report.saturated_images;
  }
  report.pyramid_seconds = clock.lap();
  return usable;
}

// A patch that is found again after a long gap may be another one.
void Frontend::State::end_after_gap(Time time) {
  if (time - last_image <= from_seconds(settings.max_gap)) return;
  report.lost_waiting += static_cast<int>(tracks.size());
  tracks.clear();
}

void Frontend::State::follow(Time time) {
  if (!tracks.empty()) {
    const Eigen::Matrix3d& cam_R_imu = cameras[0].cam_T_imu.R;
    const TrackingStep step{.camera = cameras[0],
                            .past = past,
                            .now = now[0],
                            .mask = masks[0],
                            .now_R_last = cam_R_imu * now_R_last_imu * cam_R_imu.transpose(),
                            .trusted = rotation_trusted,
                            .seconds = to_seconds(time - last_image)};
    follow_tracks(step, settings, tracks, report);
  }
  last_image = time;
  now_R_last_imu.setIdentity();
  rotation_trusted = true;
}

void Frontend::State::add_tracks() {
  StageClock clock;
  std::vector<Eigen::Vector2d> pixels;
  pixels.reserve(tracks.size());
  for (const Track& track : tracks) pixels.push_back(track.pixel);
  for (const Eigen::Vector2d& pixel : coverage.refill(now[0].levels[0], masks[0], pixels)) {
    const std::optional<WideRay> ray = wide_ray(cameras[0], pixel);
    if (!ray) continue;
    tracks.push_back({.id = next_id++,
                      .pixel = pixel,
                      .ray = *ray,
                      .anchor = {.image = past.count(), .pixel = pixel},
                      .others = std::vector<OtherView>(cameras.size() - 1)});
    ++report.added;
  }
  report.corner_seconds = clock.lap();
}

void Frontend::State::match_other(const StereoViews& views, std::size_t camera, Track& track) {
  OtherView& other = track.others[camera - 1];
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
    other.pixel = match->pixel;
    other.inverse_depth = match->inverse_depth;
  } else {
    other.inverse_depth.reset();
    other.pause = kStereoPause;
  }
}

void Frontend::State::match_others(std::size_t camera) {
  const StereoViews views(cameras[0], now[0], cameras[camera], now[camera]);
  for (Track& track : tracks) match_other(views, camera, track);
}

void Frontend::State::age_statistics() {
  if (tracks.empty()) return;
  std::vector<int> ages;
  for (const Track& track : tracks) ages.push_back(track.age);
  std::sort(ages.begin(), ages.end());
  double sum = 0;
  for (const int age : ages) sum += age;
  report.mean_age = sum / static_cast<double>(ages.size());
  report.median_age = (ages[(ages.size() - 1) / 2] + ages[ages.size() / 2]) / 2.0;
}

FeatureFrame Frontend::State::features(Time time) const {
  FeatureFrame result{.time = time};
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    for (const Track& track : tracks) {
      const auto seen = c == 0 ? std::optional(track.pixel) : track.others[c - 1].pixel;
      if (!seen) continue;
      result.pixels.push_back(
          {.landmark = track.id, .camera = static_cast<int>(c), .pixel = *seen});
    }
  }
  return result;
}

Frontend::Frontend(const FrontendSettings& settings, std::vector<Camera> cameras,
                   std::vector<GrayImage> masks) {
  validate(settings);
  if (masks.empty()) masks.resize(cameras.size());
  check_rig(cameras, masks);
  const Coverage coverage(coverage_settings_of(settings), cameras[0].width, cameras[0].height);
  const std::vector<ImagePyramid> pyramids(cameras.size());
  state_ = std::make_unique<State>(State{.settings = settings,
                                         .cameras = std::move(cameras),
                                         .masks = std::move(masks),
                                         .coverage = coverage,
                                         .report = {},
                                         .past = PastImages(settings.patch_frames),
                                         .now = pyramids});
}

Frontend::~Frontend() = default;
Frontend::Frontend(Frontend&&) noexcept = default;
Frontend& Frontend::operator=(Frontend&&) noexcept = default;

const FrontendReport& Frontend::report() const { return state_->report; }

FeatureFrame Frontend::process(const ImageFrame& frame, const RotationPrior& rotation) {
  State& state = *state_;
  check_frame(frame, rotation, state.last_frame, state.cameras);
  state.report = {.time = frame.time};
  state.last_frame = frame.time;
  state.now_R_last_imu = rotation.now_R_last_imu * state.now_R_last_imu;
  state.rotation_trusted = state.rotation_trusted && rotation.trusted;
  const std::vector<char> usable = state.build_pyramids(frame);
  state.end_after_gap(frame.time);
  if (!usable[0]) return {.time = frame.time};
  state.follow(frame.time);
  state.add_tracks();
  StageClock clock;
  for (std::size_t c = 1; c < state.cameras.size(); ++c) {
    for (Track& track : state.tracks) track.others[c - 1].pixel.reset();
    if (usable[c]) state.match_others(c);
  }
  state.report.stereo_seconds = clock.lap();
  state.age_statistics();
  state.past.push(state.now[0]);
  return state.features(frame.time);
}

}  // namespace chasles
