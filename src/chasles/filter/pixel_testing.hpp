#pragma once

#include <chasles/camera/triangulation.hpp>
#include <chasles/filter/inertial_testing.hpp>

// A filter with landmarks of both forms and clones, and its cameras, with known or estimated
// extrinsics.
namespace chasles::test {

inline ReadoutMotion some_motion(Random& random) {
  return {.rate = random.normal_vector(3),
          .rate_change = 10 * random.normal_vector(3),
          .velocity = 2 * random.normal_vector(3),
          .acceleration = 5 * random.normal_vector(3)};
}

/// Pixels vary by hundreds per radian: the numeric derivative needs a smaller step.
inline constexpr double kPixelStep = 1e-4;

inline const std::vector<Camera> kCameras = inertial_cameras();

inline Ekf some_filter(Random& random, bool calibrating) {
  return inertial_filter(kStandardChart, random, true, calibrating);
}

/// A camera of the rig, with the extrinsics of the state.
inline Camera camera_of(const State& x, int index) {
  return as_estimated(kCameras[static_cast<std::size_t>(index)], x, index);
}

inline Eigen::Vector2d pixel_of(const Camera& camera, const SE3& world_T_imu,
                                const Eigen::Vector3d& p_world) {
  return project(camera, camera.cam_T_imu * (world_T_imu.inverse() * p_world))->pixel;
}

inline std::string how_known(const testing::TestParamInfo<bool>& info) {
  return info.param ? "EstimatedCameras" : "KnownCameras";
}

}  // namespace chasles::test
