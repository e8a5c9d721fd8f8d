#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

#include <chasles/camera/feature_frame.hpp>
#include <chasles/camera/stereo.hpp>
#include <chasles/filter/textbook_motion_testing.hpp>
#include <chasles/imu/body_velocity.hpp>
#include <chasles/lie/testing.hpp>

/// A short winding stereo-velocity run past random points, with the measurements of a car's
/// sensors. For the filter's tests, which may not use the simulator of sim/. Included by tests
/// only.
namespace chasles::test {

struct DriveSettings {
  int frames = 100;
  int initial_points = 8;     ///< initial number of points, in front of the start
  int points_a_frame = 1;     ///< new points per frame
  int frames_between = 1;     ///< number of frames between frames with new points
  double outlier_share = 0;   ///< of the observations: 30 px away
  double velocity_noise = 1;  ///< factor on the samples' noise
  std::uint64_t seed = 1;
};

/// One instant, and the samples held until the next.
struct DriveFrame {
  SE3 world_T_imu;                              ///< true
  BodyVelocity velocity;                        ///< measured
  InertialSample inertial;                      ///< measured
  std::vector<StereoObservation> observations;  ///< in the order of ids
};

inline constexpr double kDriveStep = 0.1;        ///< [s]
inline constexpr double kDrivePixelNoise = 0.5;  ///< of mean u, mean v and disparity [px]

struct Drive {
  StereoRig rig;
  std::vector<DriveFrame> frames;
};

inline StereoRig drive_rig() {
  Eigen::Matrix3d axes;  // z forward, x right, y down
  axes << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return {.fx = 400,
          .fy = 420,
          .cx = 500,
          .cy = 300,
          .baseline = 0.5,
          .cam0_T_imu = {so3::exp({0.02, -0.01, 0.03}) * axes, {0.2, 0.1, -0.3}}};
}

namespace drive_detail {

inline Vector6d true_velocity(double t) {
  Vector6d u;
  u << 0.05 * std::sin(1.1 * t), 0.04 * std::cos(0.9 * t), 0.2 + 0.3 * std::sin(0.5 * t),
      8 + 2 * std::sin(0.3 * t), 0.2 * std::sin(t), 0.1 * std::cos(0.7 * t);
  return u;
}

inline bool in_view(const Eigen::Vector3d& p_cam0, const Eigen::Vector4d& pixels) {
  return p_cam0.z() > 2 && p_cam0.z() < 16 && (pixels.array() > 0).all() &&
         (pixels.array() < 1000).all();
}

inline std::vector<StereoObservation> observe(const StereoRig& rig, const SE3& world_T_imu,
                                              const std::vector<Eigen::Vector3d>& points,
                                              double outlier_share, Random& random) {
  std::vector<StereoObservation> result;
  const SE3 cam0_T_world = rig.cam0_T_imu * world_T_imu.inverse();
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector3d p_cam0 = cam0_T_world * points[i];
    const auto projection = project(rig, p_cam0);
    if (!projection || !in_view(p_cam0, projection->pixels)) continue;
    Eigen::Vector3d noise = kDrivePixelNoise * random.normal_vector(3);
    if (random.uniform() < outlier_share) noise.head<2>() += 30 * random.normal_vector(2);
    Eigen::Vector4d pixels = projection->pixels;
    pixels += Eigen::Vector4d(noise[0] + noise[2] / 2, noise[1], noise[0] - noise[2] / 2, noise[1]);
    result.push_back({.landmark = static_cast<LandmarkId>(i), .pixels = pixels});
  }
  return result;
}

}  // namespace drive_detail

inline Drive simulate_drive(const DriveSettings& settings) {
  Random random(settings.seed);
  Drive drive{.rig = drive_rig(), .frames = {}};
  std::vector<Eigen::Vector3d> points;
  SE3 world_T_imu;
  const auto put_points = [&](int count, double nearest) {
    for (int i = 0; i < count; ++i) {
      const double z = random.uniform(-1, 3), y = random.uniform(-5, 5),
                   x = random.uniform(nearest, 14);
      const Eigen::Vector3d p_imu(x, y, z);
      points.push_back(world_T_imu * p_imu);
    }
  };
  put_points(settings.initial_points, 4);
  for (int k = 0; k < settings.frames; ++k) {
    const double t = k * kDriveStep;
    if (k % settings.frames_between == 0) put_points(settings.points_a_frame, 9);
    const Vector6d u = drive_detail::true_velocity(t);
    const SE3 next = world_T_imu * se3::exp(kDriveStep * u);
    const Eigen::Vector3d v_next = next.R * drive_detail::true_velocity(t + kDriveStep).tail<3>();
    const Eigen::Vector3d acceleration = (v_next - world_T_imu.R * u.tail<3>()) / kDriveStep;
    const auto noise = [&](double sigma) -> Eigen::Vector3d {
      return settings.velocity_noise * sigma * random.normal_vector(3);
    };
    const Eigen::Vector3d f_imu =
        world_T_imu.R.transpose() * (acceleration + Eigen::Vector3d(0, 0, 9.81));
    drive.frames.push_back({
        .world_T_imu = world_T_imu,
        .velocity = {.time = {},
                     .linear_imu = u.tail<3>() + noise(0.1),
                     .angular_imu = u.head<3>() + noise(0.01)},
        .inertial = {.f_imu = f_imu + noise(0.1), .w_imu = u.head<3>() + noise(0.01)},
        .observations =
            drive_detail::observe(drive.rig, world_T_imu, points, settings.outlier_share, random),
    });
    world_T_imu = next;
  }
  return drive;
}

}  // namespace chasles::test
