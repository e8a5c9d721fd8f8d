#include <optional>

#include <chasles/base/stage_clock.hpp>
#include <chasles/frontend/camera_tracks.hpp>

namespace chasles {
namespace {

CoverageSettings coverage_settings_of(const FrontendSettings& s, int max_tracks) {
  return {.measure = s.corners,
          .max_tracks = max_tracks,
          .columns = s.grid_columns,
          .rows = s.grid_rows,
          .cells_per_search = s.cells_per_frame,
          .min_distance = s.min_distance,
          .border = s.border,
          .min_gradient = s.min_corner_gradient};
}

}  // namespace

CameraTracks::CameraTracks(const FrontendSettings& settings, const Camera& camera,
                           const GrayImage& mask, std::size_t cameras, int max_tracks)
    : settings_(settings),
      camera_(camera),
      mask_(mask),
      cameras_(cameras),
      coverage_(coverage_settings_of(settings, max_tracks), camera.width, camera.height),
      past_(settings.patch_frames) {}

void CameraTracks::turn(const RotationPrior& rotation) {
  now_R_last_imu_ = rotation.now_R_last_imu * now_R_last_imu_;
  rotation_trusted_ = rotation_trusted_ && rotation.trusted;
}

void CameraTracks::end_after_gap(Time time, FrontendReport& report) {
  if (time - last_image_ <= from_seconds(settings_.max_gap)) return;
  report.lost_waiting += static_cast<int>(tracks_.size());
  tracks_.clear();
}

void CameraTracks::follow(const ImagePyramid& now, Time time, FrontendReport& report) {
  if (!tracks_.empty()) {
    const Eigen::Matrix3d& cam_R_imu = camera_.cam_T_imu.R;
    const TrackingStep step{.camera = camera_,
                            .past = past_,
                            .now = now,
                            .mask = mask_,
                            .now_R_last = cam_R_imu * now_R_last_imu_ * cam_R_imu.transpose(),
                            .trusted = rotation_trusted_,
                            .seconds = to_seconds(time - last_image_)};
    follow_tracks(step, settings_, tracks_, report);
  }
  last_image_ = time;
  now_R_last_imu_.setIdentity();
  rotation_trusted_ = true;
}

std::size_t CameraTracks::add(const ImagePyramid& now, const std::vector<Eigen::Vector2d>& taken,
                              LandmarkId& next_id, FrontendReport& report) {
  StageClock clock;
  const std::size_t first = tracks_.size();
  std::vector<Eigen::Vector2d> pixels = taken;
  pixels.reserve(taken.size() + tracks_.size());
  for (const Track& track : tracks_) pixels.push_back(track.pixel);
  for (const Eigen::Vector2d& pixel : coverage_.refill(now, mask_, pixels)) {
    const std::optional<WideRay> ray = wide_ray(camera_, pixel);
    if (!ray) continue;
    tracks_.push_back({.id = next_id++,
                       .pixel = pixel,
                       .ray = *ray,
                       .anchor = {.image = past_.count(), .pixel = pixel},
                       .others = std::vector<OtherView>(cameras_)});
    ++report.added;
  }
  report.corner_seconds += clock.lap();
  return first;
}

}  // namespace chasles
