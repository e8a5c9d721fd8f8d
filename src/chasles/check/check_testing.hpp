#pragma once

#include <utility>

#include <chasles/camera/camera.hpp>
#include <chasles/check/check_report.hpp>
#include <chasles/recording/inertial_testing.hpp>

// A recording without any deficiency; the tests of the check add one each.
namespace chasles::test {

struct TrackedSettings {
  double seconds = 20;
  double pixel_sigma = 0.5;  ///< [px]
  double outliers = 0;       ///< share of observations at random pixels
  bool wall = false;         ///< all points in one plane
};

/// A pair of cameras 0.12 m apart, with the motion of `swung`, that observe points 2 to 6 m away at
/// 20 Hz; IMU at 200 Hz.
inline Recording tracked(const TrackedSettings& settings = {}) {
  Random random(11);
  Recording r = swung({0, 0, -kStandardGravity}, settings.seconds);
  r.name = "tracked";
  const SE3 cam0_T_imu{so3::exp({0.3, -1.1, 0.6}), {0.05, 0.01, -0.02}};
  const SE3 cam1_T_cam0{so3::exp({0, 0.003, 0}), {-0.12, 0, 0}};
  Camera camera{.width = 752,
                .height = 480,
                .fx = 460,
                .fy = 458,
                .cx = 370,
                .cy = 245,
                .distortion = Distortion::kRadtan,
                .coefficients = {-0.28, 0.07, 1e-4, 2e-5},
                .cam_T_imu = cam0_T_imu};
  r.cameras = {camera, camera};
  r.cameras[1].cam_T_imu = cam1_T_cam0 * cam0_T_imu;
  std::vector<Eigen::Vector3d> points;
  for (int j = 0; j < 300; ++j) {
    const Eigen::Vector3d direction =
        Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    points.push_back(direction * random.uniform(2, 6));
    if (settings.wall) points.back() = {random.uniform(-6, 6), random.uniform(-6, 6), 3};
  }
  for (int k = 5; 0.05 * k < settings.seconds - 0.1; ++k) {
    const StampedPose pose = swung_pose(0.05 * k);
    FeatureFrame& frame = r.frames.emplace_back();
    frame.time = pose.time;
    for (int c = 0; c < 2; ++c) {
      const Camera& lens = r.cameras[static_cast<std::size_t>(c)];
      const SE3 cam_T_world = lens.cam_T_imu * pose.pose.inverse();
      for (std::size_t j = 0; j < points.size(); ++j) {
        const auto seen = project(lens, cam_T_world * points[j]);
        if (!seen || !in_image(lens, seen->pixel)) continue;
        Eigen::Vector2d pixel = seen->pixel;
        pixel += settings.pixel_sigma * Eigen::Vector2d(random.normal(), random.normal());
        if (random.uniform(0, 1) < settings.outliers) {
          pixel = {random.uniform(0, 751), random.uniform(0, 479)};
        }
        frame.pixels.push_back(
            {.landmark = static_cast<LandmarkId>(j), .camera = c, .pixel = pixel});
      }
    }
  }
  return r;
}

/// The finding about `about` whose sentence contains `part`. The test fails if there is none.
inline Finding finding(const CheckReport& report, const std::string& about,
                       const std::string& part) {
  std::string all;
  for (const Finding& f : report.findings) {
    if (f.about == about && f.what.find(part) != std::string::npos) return f;
    all += f.about + ": " + f.what + "\n";
  }
  ADD_FAILURE() << "no finding about " << about << " with '" << part << "' in:\n" << all;
  return {};
}

inline double fact(const CheckReport& report, const std::string& about, const std::string& name) {
  for (const Fact& f : report.facts) {
    if (f.about == about && f.name == name) return f.value;
  }
  ADD_FAILURE() << "no fact '" << name << "' about " << about;
  return 0;
}

inline std::string findings(const CheckReport& report) {
  std::string all;
  for (const Finding& f : report.findings) all += f.about + ": " + f.what + "\n";
  return all;
}

}  // namespace chasles::test
