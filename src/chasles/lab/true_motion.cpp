#include <utility>

#include <fmt/format.h>

#include <chasles/base/constants.hpp>
#include <chasles/base/error.hpp>
#include <chasles/lab/true_motion.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/recording/gravity.hpp>
#include <chasles/sim/inertial_imu.hpp>
#include <chasles/smooth/batch/pose_fusion.hpp>

namespace chasles {

std::string make_agree(InertialScene& scene) {
  const auto fit = fit_gravity(scene.path, scene.imu);
  if (!fit) {
    throw InputError(fmt::format(
        "truth and IMU samples do not determine gravity: found {} poses and {} samples, expected "
        "three seconds of both at the same times",
        scene.path.size(), scene.imu.size()));
  }
  const SE3 upright{so3::between(fit->gravity_world, -Eigen::Vector3d::UnitZ()),
                    Eigen::Vector3d::Zero()};
  for (StampedPose& pose : scene.path) pose.pose = upright * pose.pose;
  PoseFusion fused = fuse_poses(scene.path, scene.imu,
                                {.noise = imu_noise(scene.settings),
                                 .imu = {.convention = scene.settings.imu_convention},
                                 .accelerometer_bias = fit->accelerometer_bias});
  scene.path = std::move(fused.world_T_imu);
  return fmt::format(
      "truth: rotated upright by {:.2f} deg, then moved by {:.1f} mm and {:.2f} mrad (rms) to what "
      "it and the IMU agree on (cost per degree of freedom {:.2f}, {} steps)",
      so3::log(upright.R).norm() * kDegrees, 1e3 * fused.position_moved, 1e3 * fused.rotation_moved,
      fused.cost_per_dof, fused.iterations);
}

}  // namespace chasles
