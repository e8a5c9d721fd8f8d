#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Geometry>

#include <chasles/check/check_rotation.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {
namespace {

constexpr double kInterval = 0.25;  // between two frames [s]
constexpr std::size_t kFewestTracks = 12, kMostFrames = 400;
constexpr double kSpread = 0.174;  // [rad]

struct Ray {
  LandmarkId landmark = 0;
  Eigen::Vector3d direction;
  double row = 0;      // from the middle of the image, over its height
  double stretch = 0;  // of TwoRays
};

double row_of(const Camera& camera, const Eigen::Vector2d& pixel) {
  return camera.height > 0 ? pixel.y() / camera.height - 0.5 : 0;
}

double angle_of(const Eigen::Vector3d& ray) { return std::atan2(ray.head<2>().norm(), ray.z()); }

double stretch_of(const Camera& camera, const Eigen::Vector2d& pixel, const Eigen::Vector3d& ray) {
  constexpr double kFarther = 1e-3;
  const Eigen::Vector2d centre(camera.cx, camera.cy);
  const auto farther = wide_ray(camera, centre + (1 + kFarther) * (pixel - centre));
  return farther ? (angle_of(farther->ray) - angle_of(ray)) / kFarther : angle_of(ray);
}

std::vector<Ray> rays_of(const FeatureFrame& frame, const Camera& camera, int index) {
  std::vector<Ray> rays;
  for (const PixelObservation& o : frame.pixels) {
    if (o.camera != index) continue;
    if (const auto ray = wide_ray(camera, o.pixel)) {
      rays.push_back({o.landmark, ray->ray.normalized(), row_of(camera, o.pixel),
                      stretch_of(camera, o.pixel, ray->ray)});
    }
  }
  std::sort(rays.begin(), rays.end(),
            [](const Ray& a, const Ray& b) { return a.landmark < b.landmark; });
  return rays;
}

// Cameras may take turns.
std::vector<const FeatureFrame*> frames_of(const std::vector<FeatureFrame>& all, int camera) {
  std::vector<const FeatureFrame*> frames;
  for (const FeatureFrame& frame : all) {
    if ((observing(frame) & camera_bit(camera)) != 0) frames.push_back(&frame);
  }
  return frames;
}

std::vector<TwoRays> common(const std::vector<Ray>& first, const std::vector<Ray>& second) {
  std::vector<TwoRays> pairs;
  auto b = second.begin();
  for (const Ray& a : first) {
    while (b != second.end() && b->landmark < a.landmark) ++b;
    if (b != second.end() && b->landmark == a.landmark) {
      pairs.push_back({a.direction, b->direction, a.row, b->row, a.stretch, b->stretch});
    }
  }
  return pairs;
}

// Rays in similar directions do not distinguish a rotation from a sideways translation.
bool spread(const std::vector<TwoRays>& pairs) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const TwoRays& pair : pairs) sum += pair.first;
  const Eigen::Vector3d middle = sum.normalized();
  double square = 0;
  for (const TwoRays& pair : pairs) square += middle.cross(pair.first).squaredNorm();
  return square >= kSpread * kSpread * static_cast<double>(pairs.size());
}

}  // namespace

std::vector<SeenTwice> seen_twice(const std::vector<FeatureFrame>& all,
                                  const std::vector<Camera>& cameras, int camera) {
  const auto frames = frames_of(all, camera);
  const Camera& lens = cameras[static_cast<std::size_t>(camera)];
  const std::size_t step = 1 + frames.size() / kMostFrames;
  std::vector<SeenTwice> seen;
  for (std::size_t k = 0, next = 0; k < frames.size(); k += step) {
    while (next < frames.size() && to_seconds(frames[next]->time - frames[k]->time) < kInterval) {
      ++next;
    }
    if (next == frames.size()) break;
    auto pairs = common(rays_of(*frames[k], lens, camera), rays_of(*frames[next], lens, camera));
    if (pairs.size() < kFewestTracks || !spread(pairs)) continue;
    seen.push_back({frames[k]->time, frames[next]->time, std::move(pairs)});
  }
  return seen;
}

std::vector<RotationRate> rotation_rates(const std::vector<SeenTwice>& seen,
                                         const RotationGuess& guess) {
  std::vector<RotationRate> rates;
  for (const SeenTwice& two : seen) {
    const auto rotation =
        relative_rotation(two.pairs, guess ? guess(two.begin, two.end) : std::nullopt);
    if (!rotation) continue;
    const double seconds = to_seconds(two.end - two.begin);
    rates.push_back({.begin = two.begin,
                     .end = two.end,
                     .rate_cam = -so3::log(rotation->second_R_first) / seconds,
                     .information = rotation->information * (seconds * seconds)});
  }
  return rates;
}

}  // namespace chasles
