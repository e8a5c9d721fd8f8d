#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/frontend/frontend_testing.hpp>

/// Walks through the room with a front end, compared with the truth. Included by tests only.
namespace chasles::test {

using Path = std::function<SE3(int)>;

inline double median(std::vector<double> values) {
  if (values.empty()) return 1e9;
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

/// A path through the room as input of a front end.
struct Walk {
  std::vector<Camera> rig = {euroc_rig()[0]};
  Path path = walk_pose;
  int frames = 12;
  bool gyroscope = true;
  FrontendSettings settings = {};
};

/// The results, compared with the truth.
struct Outcome {
  std::vector<FeatureFrame> features;
  std::vector<FrontendReport> reports;
  std::vector<double> step_errors;   ///< from a frame to the next [px]
  std::vector<double> total_errors;  ///< from a track's first frame to the last one [px]
  double tracked_share = 0;          ///< of the points that stay in the image, each step
};

inline ImageFrame frame_of(const Walk& walk, int k) {
  return render_frame(room(), walk.rig, walk.path(k), from_seconds(1 + 0.05 * k));
}

inline std::map<LandmarkId, Eigen::Vector2d> of_camera(const FeatureFrame& features, int camera) {
  std::map<LandmarkId, Eigen::Vector2d> pixels;
  for (const PixelObservation& o : features.pixels) {
    if (o.camera == camera) pixels[o.landmark] = o.pixel;
  }
  return pixels;
}

inline Outcome follow(const Walk& walk) {
  Outcome out;
  Frontend frontend(walk.settings, walk.rig);
  const Camera& camera = walk.rig[0];
  const auto pose = [&](int k) { return walk.path(k) * camera.cam_T_imu.inverse(); };
  std::map<LandmarkId, Eigen::Vector2d> last;
  std::map<LandmarkId, std::pair<int, Eigen::Vector2d>> first;
  double stayed = 0, tracked = 0;
  for (int k = 0; k < walk.frames; ++k) {
    const RotationPrior prior =
        k > 0 && walk.gyroscope ? gyroscope(walk.path(k - 1), walk.path(k)) : RotationPrior{};
    out.features.push_back(frontend.process(frame_of(walk, k), prior));
    out.reports.push_back(frontend.report());
    const auto now = of_camera(out.features.back(), 0);
    for (const auto& [id, pixel] : last) {
      const auto truth = room().true_pixel(camera, pose(k - 1), pixel, camera, pose(k));
      if (!truth || !in_image(camera, *truth, 12)) continue;
      stayed += 1;
      if (!now.contains(id)) continue;
      tracked += 1;
      out.step_errors.push_back((now.at(id) - *truth).norm());
    }
    for (const auto& [id, pixel] : now) first.try_emplace(id, k, pixel);
    last = now;
  }
  for (const auto& [id, pixel] : last) {
    const auto& [k, begin] = first.at(id);
    const auto truth = room().true_pixel(camera, pose(k), begin, camera, pose(walk.frames - 1));
    if (truth && k < walk.frames - 1) out.total_errors.push_back((pixel - *truth).norm());
  }
  out.tracked_share = tracked / std::max(1.0, stayed);
  return out;
}

inline SE3 sideways(int k) { return {Eigen::Matrix3d::Identity(), {0.02 * k, 0.01 * k, 0.01 * k}}; }

/// 30 degrees a frame, about an axis that differs from the camera's axes; the room has walls on all
/// sides.
inline SE3 spin(int k) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 0.15, 0.5).normalized();
  return {so3::exp(k * std::numbers::pi / 6 * axis), {0.1, 0.2, -0.1}};
}

}  // namespace chasles::test
