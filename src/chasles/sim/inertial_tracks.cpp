#include <algorithm>
#include <map>
#include <optional>

#include <chasles/base/interruption.hpp>
#include <chasles/camera/rig_overlap.hpp>
#include <chasles/sim/inertial_tracks.hpp>

namespace chasles {
namespace {

// Of the search for the line at which a point is seen [px].
constexpr double kSamePixel = 1e-6;

class Tracker {
 public:
  Tracker(const InertialSettings& settings, const InertialWorld& world,
          const std::vector<Camera>& cameras, const Trajectory& poses, const Spline& motion)
      : settings_(settings),
        world_(world),
        cameras_(cameras),
        finders_(finders_of(cameras)),
        poses_(poses),
        motion_(motion),
        numbers_(world.points.size()),
        tracked_(world.points.size(), false) {}

  InertialTracks follow_all() {
    for (std::size_t i = 0; i < poses_.size(); ++i) {
      interruption_point();
      frame_ = {.time = poses_[i].time};
      follow_on(i);
      begin_missing(i);
      std::ranges::sort(frame_.pixels, {}, [](const PixelObservation& seen) {
        return std::pair(seen.landmark, seen.camera);
      });
      tracks_.frames.push_back(frame_);
    }
    return std::move(tracks_);
  }

 private:
  // A track: its point, and the camera that found it, if the tracks state it.
  struct Alive {
    std::size_t point = 0;
    std::optional<std::size_t> finder = {};
  };

  std::optional<Eigen::Vector2d> visible_pixel_of(std::size_t point, std::size_t camera,
                                                  std::size_t pose) const {
    const Camera& seeing = cameras_[camera];
    auto pixel = pixel_from(poses_[pose].pose, point, seeing);
    if (!pixel || !seeing.shutter.is_rolling()) return pixel;
    const double time = to_seconds(poses_[pose].time - motion_.start);
    Eigen::Vector2d before;
    do {
      before = *pixel;
      const double at = time + line_delay(seeing, before);
      pixel = pixel_from(motion_at(motion_, at).world_T_imu, point, seeing);
    } while (pixel && (*pixel - before).norm() > kSamePixel);
    return pixel;
  }

  std::optional<Eigen::Vector2d> pixel_from(const SE3& world_T_imu, std::size_t point,
                                            const Camera& camera) const {
    return visible_pixel(settings_, world_, camera, world_T_imu, world_.points[point]);
  }

  bool is_visible(std::size_t point, std::size_t pose) const {
    for (std::size_t camera = 0; camera < cameras_.size(); ++camera) {
      if (visible_pixel_of(point, camera, pose)) return true;
    }
    return false;
  }

  // The first finder that sees the point, else the first one. None with a single finder: the tracks
  // are camera 0's, as those of recordings that do not state it.
  std::optional<std::size_t> finder_of(std::size_t point, std::size_t pose) const {
    if (finders_.size() < 2) return std::nullopt;
    const auto sees = [&](const Finder& finder) {
      return visible_pixel_of(point, finder.camera, pose).has_value();
    };
    const auto first = std::ranges::find_if(finders_, sees);
    return first != finders_.end() ? first->camera : 0;
  }

  // Adds the point's pixels to the frame; false if no camera sees it.
  bool observe(const Alive& track, LandmarkId landmark, std::size_t pose) {
    const std::size_t before = frame_.pixels.size();
    for (std::size_t camera = 0; camera < cameras_.size(); ++camera) {
      const auto pixel = visible_pixel_of(track.point, camera, pose);
      if (!pixel) continue;
      frame_.pixels.push_back(
          {.landmark = landmark, .camera = static_cast<int>(camera), .pixel = *pixel});
      if (track.finder) frame_.pixels.back().match = camera != *track.finder;
    }
    return frame_.pixels.size() > before;
  }

  void follow_on(std::size_t pose) {
    std::erase_if(alive_, [&](const auto& track) {
      if (observe(track.second, track.first, pose)) return false;
      tracked_[track.second.point] = false;
      return true;
    });
  }

  void begin_missing(std::size_t pose) {
    const auto wanted = static_cast<std::size_t>(settings_.landmarks_in_view);
    const auto later =
        std::min(pose + static_cast<std::size_t>(settings_.shortest_track) - 1, poses_.size() - 1);
    for (std::size_t point = 0; point < tracked_.size() && alive_.size() < wanted; ++point) {
      if (tracked_[point] || !is_visible(point, pose) || !is_visible(point, later)) continue;
      const LandmarkId landmark = number_of(point);
      const Alive track{.point = point, .finder = finder_of(point, pose)};
      observe(track, landmark, pose);
      tracked_[point] = true;
      alive_.emplace(landmark, track);
    }
  }

  LandmarkId number_of(std::size_t point) {
    if (settings_.keep_ids && numbers_[point]) return *numbers_[point];
    numbers_[point] = static_cast<LandmarkId>(tracks_.points.size());
    tracks_.points.push_back(point);
    return *numbers_[point];
  }

  const InertialSettings& settings_;
  const InertialWorld& world_;
  const std::vector<Camera>& cameras_;
  std::vector<Finder> finders_;
  const Trajectory& poses_;
  const Spline& motion_;
  InertialTracks tracks_;
  FeatureFrame frame_;
  std::map<LandmarkId, Alive> alive_;
  std::vector<std::optional<LandmarkId>> numbers_;  // the latest number of each point
  std::vector<bool> tracked_;
};

}  // namespace

InertialTracks follow(const InertialSettings& settings, const InertialWorld& world,
                      const std::vector<Camera>& cameras, const Trajectory& poses,
                      const Spline& motion) {
  return Tracker(settings, world, cameras, poses, motion).follow_all();
}

}  // namespace chasles
