#include <algorithm>
#include <cmath>
#include <optional>

#include <chasles/numeric/random.hpp>
#include <chasles/sim/street_tracks.hpp>

namespace chasles {
namespace {

// Rays tried for each missing track: enough if an eighth of the image shows valid points.
constexpr std::uint32_t kTries = 8;

// The pixels of a point that both cameras see.
std::optional<Eigen::Vector4d> seen(const StreetView& view, const SE3& world_T_cam0,
                                    const Eigen::Vector3d& p_world) {
  const StreetSettings& settings = view.settings;
  const Eigen::Vector3d p_cam0 = world_T_cam0.inverse() * p_world;
  if (p_cam0.z() < settings.min_depth || p_cam0.z() > settings.max_depth) return std::nullopt;
  const auto projection = project(view.rig, p_cam0);
  if (!projection) return std::nullopt;
  const Eigen::Array4d pixels = projection->pixels.array();
  const Eigen::Array4d high(settings.image_width, settings.image_height, settings.image_width,
                            settings.image_height);
  const double border = settings.image_border;
  if ((pixels < border).any() || (pixels > high - 1 - border).any()) return std::nullopt;
  if (blocked(view.world, world_T_cam0.p, p_world)) return std::nullopt;
  return projection->pixels;
}

SE3 camera_at(const StreetView& view, double time) {
  const double until = std::min(time, view.drive.duration);
  return state_at(view.drive, until).world_T_imu * view.rig.cam0_T_imu.inverse();
}

Eigen::Vector3d position_at(const StreetTrack& track, double time) {
  return track.p_world + (time - track.birth) * track.v_world;
}

Eigen::Vector3d moving_velocity(const StreetView& view, double time, std::uint64_t id) {
  const Random random{view.settings.seed};
  if (random.uniform(Stream::kMoving, id) >= view.settings.moving_fraction) {
    return Eigen::Vector3d::Zero();
  }
  const double side = random.uniform(Stream::kMoving, id, 1) < 0.5 ? -1 : 1;
  const double heading = state_at(view.drive, time).heading;
  return side * view.settings.moving_speed *
         Eigen::Vector3d(std::cos(heading), std::sin(heading), 0);
}

// The point that the ray of one try meets.
std::optional<Eigen::Vector3d> find_point(const StreetView& view, const SE3& world_T_cam0,
                                          std::uint64_t frame, std::uint32_t attempt) {
  const StreetSettings& settings = view.settings;
  const Random random{settings.seed};
  const double u = settings.image_width * random.uniform(Stream::kBirth, frame, 2 * attempt);
  const double v = settings.image_height * random.uniform(Stream::kBirth, frame, 2 * attempt + 1);
  const Eigen::Vector3d ray_cam0((u - view.rig.cx) / view.rig.fx, (v - view.rig.cy) / view.rig.fy,
                                 1);
  const Eigen::Vector3d ray_world = world_T_cam0.R * ray_cam0;
  const auto depth = cast(view.world, world_T_cam0.p, ray_world);
  if (!depth) return std::nullopt;
  return world_T_cam0.p + *depth * ray_world;
}

void give_birth(Tracks& tracks, const StreetView& view, std::uint64_t frame, double time) {
  const StreetSettings& settings = view.settings;
  const double sure_life = (settings.shortest_track - 1) / settings.frame_rate;
  const SE3 now = camera_at(view, time);
  const SE3 then = camera_at(view, time + sure_life);
  const auto wanted = static_cast<std::size_t>(settings.features_per_frame);
  const auto tries = kTries * static_cast<std::uint32_t>(wanted - tracks.alive.size());
  for (std::uint32_t attempt = 0; attempt < tries && tracks.alive.size() < wanted; ++attempt) {
    const auto point = find_point(view, now, frame, attempt);
    if (!point) continue;
    const std::uint64_t id = tracks.born.size();
    StreetTrack track{.id = static_cast<LandmarkId>(id),
                      .p_world = *point,
                      .v_world = moving_velocity(view, time, id),
                      .birth = time};
    const auto pixels = seen(view, now, *point);
    if (!pixels || !seen(view, then, position_at(track, time + sure_life))) continue;
    track.pixels = *pixels;
    track.end = time + sure_life -
                settings.track_life * std::log(Random{settings.seed}.uniform(Stream::kLife, id));
    tracks.alive.push_back(track);
    tracks.born.push_back(track);
  }
}

}  // namespace

void follow(Tracks& tracks, const StreetView& view, std::uint64_t frame, double time) {
  const SE3 world_T_cam0 = camera_at(view, time);
  std::erase_if(tracks.alive, [&](StreetTrack& track) {
    if (time > track.end) return true;
    const auto pixels = seen(view, world_T_cam0, position_at(track, time));
    if (pixels) track.pixels = *pixels;
    return !pixels;
  });
  if (tracks.alive.size() < static_cast<std::size_t>(view.settings.features_per_frame)) {
    give_birth(tracks, view, frame, time);
  }
}

}  // namespace chasles
