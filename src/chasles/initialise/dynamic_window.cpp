#include <algorithm>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include <Eigen/LU>

#include <chasles/camera/anchor_face.hpp>
#include <chasles/initialise/dynamic_window.hpp>

namespace chasles {
namespace {

// The index of a camera's other face behind those of all cameras.
int axes_of(AnchorFace face, int camera, int cameras) {
  return cameras + (kAnchorFaces - 1) * camera + static_cast<int>(face) - 1;
}

void add_axes(const std::vector<Camera>& cameras, MotionWindow& window) {
  for (const Camera& camera : cameras) window.cam_T_imu.push_back(camera.cam_T_imu);
  for (const Camera& camera : cameras) {
    for (int face = 1; face < kAnchorFaces; ++face) {
      window.cam_T_imu.push_back(face_T_imu(static_cast<AnchorFace>(face), camera.cam_T_imu));
    }
  }
  for (const SE3& cam_T_imu : window.cam_T_imu) window.imu_T_cam.push_back(cam_T_imu.inverse());
}

std::optional<PlaneView> plane_view(const PixelObservation& o, int keyframe,
                                    const std::vector<Camera>& rig, double pixel_sigma,
                                    const MeasuredReadout& readout) {
  const Camera& camera = rig[static_cast<std::size_t>(o.camera)];
  if (!o.pixel.allFinite()) return std::nullopt;
  const std::optional<FaceRay> ray = face_ray(camera, o.pixel);
  if (!ray) return std::nullopt;
  PlaneView view{.keyframe = keyframe, .camera = o.camera, .axes = o.camera, .xy = ray->xy};
  view.whitening = (pixel_sigma * ray->d_pixel).inverse();
  view.ray_imu = face_T_imu(ray->face, camera.cam_T_imu).R.transpose() *
                 Eigen::Vector3d(ray->xy.x(), ray->xy.y(), 1).normalized();
  view.angle_sigma = 2 * pixel_sigma / focal_lengths_at_axis(camera).sum();
  if (ray->face != AnchorFace::kFront) {
    view.axes = axes_of(ray->face, o.camera, static_cast<int>(rig.size()));
    view.angle_sigma = pixel_sigma * bearing(camera, o.pixel)->d_pixel.norm() / std::numbers::sqrt2;
  }
  if (camera.shutter.is_rolling()) {
    view.delay = line_delay(camera, o.pixel);
    view.imu_R_line = readout.rotation_after(view.delay);
    view.ray_imu = view.imu_R_line * view.ray_imu;
  }
  return view;
}

int keyframe_count(const PlaneTrack& track) {
  std::set<int> seen;
  for (const PlaneView& view : track) seen.insert(view.keyframe);
  return static_cast<int>(seen.size());
}

bool is_stereo(const PlaneTrack& track) {
  return keyframe_count(track) < static_cast<int>(track.size());
}

}  // namespace

std::vector<std::size_t> choose_keyframes(std::size_t frames, int count) {
  const std::size_t n = std::min(frames, static_cast<std::size_t>(std::max(count, 2)));
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < n; ++i) {
    chosen.push_back(n < 2 ? 0 : (i * (frames - 1) + (n - 1) / 2) / (n - 1));
  }
  return chosen;
}

MotionWindow make_window(const std::vector<FeatureFrame>& keyframes,
                         const std::vector<Camera>& cameras, double pixel_sigma, int max_tracks,
                         std::vector<MeasuredReadout> readouts) {
  MotionWindow window;
  readouts.resize(keyframes.size());
  window.readouts = std::move(readouts);
  add_axes(cameras, window);
  for (const Camera& camera : cameras) {
    window.focal.push_back(focal_lengths_at_axis(camera).sum() / 2);
  }
  std::map<LandmarkId, PlaneTrack> by_id;
  for (const FeatureFrame& frame : keyframes) {
    const int k = static_cast<int>(window.times.size());
    window.times.push_back(frame.time);
    std::set<std::pair<LandmarkId, int>> seen;
    for (const PixelObservation& o : frame.pixels) {
      if (o.camera < 0 || o.camera >= static_cast<int>(cameras.size())) continue;
      if (!seen.insert({o.landmark, o.camera}).second) continue;
      const auto view =
          plane_view(o, k, cameras, pixel_sigma, window.readouts[static_cast<std::size_t>(k)]);
      if (view) by_id[o.landmark].push_back(*view);
    }
  }
  for (auto& [id, track] : by_id) {
    if (keyframe_count(track) >= 3) window.tracks.push_back(std::move(track));
  }
  std::ranges::stable_sort(window.tracks, [](const PlaneTrack& a, const PlaneTrack& b) {
    return std::pair(keyframe_count(a), a.size()) > std::pair(keyframe_count(b), b.size());
  });
  if (window.tracks.size() > static_cast<std::size_t>(max_tracks)) {
    window.tracks.resize(static_cast<std::size_t>(max_tracks));
  }
  window.stereo_tracks = static_cast<int>(std::ranges::count_if(window.tracks, is_stereo));
  return window;
}

int views_of(const MotionWindow& window) {
  int views = 0;
  for (const PlaneTrack& track : window.tracks) views += static_cast<int>(track.size());
  return views;
}

}  // namespace chasles
