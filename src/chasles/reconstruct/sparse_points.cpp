#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include <chasles/base/constants.hpp>
#include <chasles/camera/triangulation.hpp>
#include <chasles/reconstruct/sparse_points.hpp>

namespace chasles {
namespace {

// An observation of some track, as the place of its keyframe and of its pixel there.
struct Sighting {
  LandmarkId track = 0;
  std::uint32_t keyframe = 0, pixel = 0;
};

bool is_in_front(const Camera& camera, const Eigen::Vector2d& pixel) {
  const auto direction = bearing(camera, pixel);
  return direction && direction->bearing.z() > 0;
}

// By track, then by keyframe and camera.
std::vector<Sighting> sightings(std::span<const PosedTracks> keyframes,
                                const std::vector<Camera>& cameras) {
  std::vector<Sighting> all;
  for (std::uint32_t k = 0; k < keyframes.size(); ++k) {
    const std::vector<TrackedPixel>& pixels = keyframes[k].images->pixels;
    for (std::uint32_t i = 0; i < pixels.size(); ++i) {
      if (!is_in_front(cameras[pixels[i].camera], pixels[i].pixel)) continue;
      all.push_back({.track = pixels[i].track, .keyframe = k, .pixel = i});
    }
  }
  std::ranges::stable_sort(all, {}, &Sighting::track);
  return all;
}

// The lengths of the reprojection errors [px]; none if a view does not have the point before it.
std::optional<std::vector<double>> errors_of(const Eigen::Vector3d& p_world,
                                             std::span<const View> views) {
  std::vector<double> errors;
  for (const View& view : views) {
    const Eigen::Vector3d p_cam = view.camera->cam_T_imu * (view.world_T_imu.inverse() * p_world);
    const auto projection = project(*view.camera, p_cam);
    if (!projection || p_cam.z() <= 0) return std::nullopt;
    errors.push_back((projection->pixel - view.pixel).norm());
  }
  return errors;
}

template <typename Values>
double mean(const Values& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

// Makes points of tracks, one after the other.
class Triangulator {
 public:
  Triangulator(std::span<const PosedTracks> keyframes, const std::vector<Camera>& cameras,
               const ColmapSettings& settings)
      : keyframes_(keyframes), cameras_(cameras), settings_(settings) {}

  void add(std::span<const Sighting> track) {
    if (track.size() < static_cast<std::size_t>(settings_.min_observations)) {
      ++result_.too_short;
      return;
    }
    std::vector<View> views;
    std::vector<double> greys;
    for (const Sighting& s : track) {
      const TrackedPixel& seen = pixel_of(s);
      views.push_back({.world_T_imu = keyframes_[s.keyframe].world_T_imu,
                       .camera = &cameras_[seen.camera],
                       .pixel = seen.pixel});
      greys.push_back(seen.grey);
    }
    const auto point = triangulate(views);
    const auto errors = point ? errors_of(point->p_world, views) : std::nullopt;
    if (!errors || point->parallax < settings_.min_parallax * kRadians) {
      ++result_.too_uncertain;
      return;
    }
    const double error = mean(*errors);
    if (error > settings_.max_error) {
      ++result_.too_wrong;
      return;
    }
    for (const Sighting& s : track) {
      const TrackedPixel& seen = pixel_of(s);
      result_.observations.push_back({.keyframe = s.keyframe,
                                      .camera = seen.camera,
                                      .pixel = seen.pixel,
                                      .point = result_.points.size()});
    }
    result_.points.push_back({.p_world = point->p_world,
                              .error = error,
                              .grey = static_cast<std::uint8_t>(std::lround(mean(greys)))});
  }

  SparsePoints take() { return std::move(result_); }

 private:
  const TrackedPixel& pixel_of(const Sighting& s) const {
    return keyframes_[s.keyframe].images->pixels[s.pixel];
  }

  std::span<const PosedTracks> keyframes_;
  const std::vector<Camera>& cameras_;
  const ColmapSettings& settings_;
  SparsePoints result_;
};

}  // namespace

SparsePoints sparse_points(std::span<const PosedTracks> keyframes,
                           const std::vector<Camera>& cameras, const ColmapSettings& settings) {
  const std::vector<Sighting> all = sightings(keyframes, cameras);
  Triangulator triangulator(keyframes, cameras, settings);
  for (auto begin = all.begin(); begin != all.end();) {
    const auto end =
        std::find_if(begin, all.end(), [&](const Sighting& s) { return s.track != begin->track; });
    triangulator.add({begin, end});
    begin = end;
  }
  return triangulator.take();
}

}  // namespace chasles
