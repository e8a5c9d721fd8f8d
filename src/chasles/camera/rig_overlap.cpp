#include <algorithm>

#include <chasles/camera/rig_overlap.hpp>

namespace chasles {
namespace {

constexpr int kGridColumns = 24, kGridRows = 16;
constexpr int kLeastPerFinder = 40;

bool sees(const Camera& camera, const Eigen::Vector3d& p_imu) {
  const auto seen = project(camera, camera.cam_T_imu * p_imu);
  return seen && in_image(camera, seen->pixel);
}

}  // namespace

double shared_view(const Camera& camera, const std::vector<Camera>& others) {
  const SE3 imu_T_cam = camera.cam_T_imu.inverse();
  int rays = 0, shared = 0;
  for (int i = 0; i < kGridColumns * kGridRows; ++i) {
    const Eigen::Vector2d pixel((i % kGridColumns + 0.5) / kGridColumns * camera.width,
                                (i / kGridColumns + 0.5) / kGridRows * camera.height);
    const auto ray = bearing(camera, pixel);
    if (!ray) continue;
    ++rays;
    const Eigen::Vector3d p_imu = imu_T_cam * (kNominalDepth * ray->bearing);
    shared += std::ranges::any_of(others, [&](const Camera& other) { return sees(other, p_imu); });
  }
  return rays > 0 ? static_cast<double>(shared) / rays : 0;
}

namespace {

// Either may have the wider view.
bool overlap(const Camera& a, const Camera& b) {
  return shared_view(a, {b}) >= kBarelySeen || shared_view(b, {a}) >= kBarelySeen;
}

}  // namespace

std::vector<Finder> finders_of(const std::vector<Camera>& cameras) {
  std::vector<Finder> finders;
  std::vector<Camera> finding;
  for (std::size_t c = 0; c < cameras.size(); ++c) {
    if (shared_view(cameras[c], finding) >= kMostlySeen) continue;
    finders.push_back({.camera = c});
    finding.push_back(cameras[c]);
  }
  for (Finder& finder : finders) {
    for (std::size_t c = 0; c < cameras.size(); ++c) {
      if (c != finder.camera && overlap(cameras[finder.camera], cameras[c])) {
        finder.searched.push_back(c);
      }
    }
  }
  return finders;
}

std::vector<bool> are_finders(const std::vector<Camera>& cameras) {
  std::vector<bool> are(cameras.size(), false);
  for (const Finder& finder : finders_of(cameras)) are[finder.camera] = true;
  return are;
}

std::size_t cameras_in_stereo(const std::vector<Camera>& cameras) {
  const std::vector<Finder> finders = finders_of(cameras);
  const bool any =
      std::ranges::any_of(finders, [](const Finder& finder) { return !finder.searched.empty(); });
  return any ? cameras.size() : 1;
}

int tracks_per_finder(int max_tracks, std::size_t finders) {
  const int share = max_tracks / static_cast<int>(finders);
  return std::min(max_tracks, std::max(share, kLeastPerFinder));
}

}  // namespace chasles
