#pragma once

#include <cmath>
#include <vector>

#include <chasles/calibrate/calibrate_testing.hpp>
#include <chasles/calibrate/inertial_calibration.hpp>
#include <chasles/camera/camera_testing.hpp>

/// A rig with an IMU that moves before a target, with truth. Included by tests only.
namespace chasles::test {

struct BoardRigScene {
  std::vector<Camera> cameras;  ///< with cam_T_imu and shutter
  double time_offset = 0;       ///< camera clock + offset = IMU clock [s]
  double seconds = 20;
  double frame_rate = 20, imu_rate = 200;
  double pixel_sigma = 0.2;
  ImuNoise noise{.accelerometer_noise_density = 2e-3,
                 .accelerometer_random_walk = 3e-4,
                 .gyroscope_noise_density = 1.7e-4,
                 .gyroscope_random_walk = 2e-5};
  ImuCorrection imu = {};     ///< true corrections of the measured samples
  double turning = 1;         ///< factor on the turns
  std::size_t recording = 0;  ///< whose gravity it has
};

/// Mounted as on EuRoC's rig: turned by a quarter, some centimetres away.
inline std::vector<Camera> mounted(std::size_t count, double readout = 0) {
  std::vector<Camera> cameras = {euroc_camera(), euroc_camera()};
  cameras[0].cam_T_imu = {so3::exp(Eigen::Vector3d(0.02, -0.01, 1.55)), {0.06, -0.02, 0.01}};
  cameras[1].cam_T_imu = {so3::exp(Eigen::Vector3d(0.01, 0.02, 1.56)), {-0.05, -0.02, 0.012}};
  for (Camera& camera : cameras) camera.shutter.readout = readout;
  cameras.resize(count);
  return cameras;
}

/// Smooth sums of sines; the board is about 0.9 m before the rig.
class BoardMotion {
 public:
  explicit BoardMotion(double turning) : turning_(turning) {}

  SE3 target_T_imu(double t) const {
    const Eigen::Vector3d turn(0.35 * std::sin(1.9 * t) + 0.1 * std::sin(5.3 * t),
                               0.35 * std::sin(2.3 * t + 1) + 0.08 * std::sin(6.1 * t),
                               0.5 * std::sin(1.3 * t + 2));
    const Eigen::Vector3d shift(0.25 * std::sin(1.1 * t) + 0.04 * std::sin(6.7 * t),
                                0.2 * std::sin(1.7 * t + 0.5) + 0.03 * std::sin(7.3 * t),
                                0.25 * std::sin(0.9 * t + 1) + 0.03 * std::sin(5.9 * t));
    SE3 pose;
    pose.R = so3::exp(Eigen::Vector3d(std::numbers::pi, 0, 0)) * so3::exp(turning_ * turn);
    pose.p = Eigen::Vector3d(0.27, 0.27, 0.9) + shift;
    return pose;
  }
  Eigen::Vector3d rate_imu(double t) const {
    constexpr double h = 1e-4;
    return so3::log(target_T_imu(t - h).R.transpose() * target_T_imu(t + h).R) / (2 * h);
  }
  Eigen::Vector3d acceleration(double t) const {
    constexpr double h = 1e-3;
    return (target_T_imu(t - h).p - 2 * target_T_imu(t).p + target_T_imu(t + h).p) / (h * h);
  }

 private:
  double turning_;
};

/// Gravity in the target's frame: the board leans, and lies on the ground in another recording.
inline Eigen::Vector3d true_gravity(std::size_t recording = 0) {
  return so3::exp(Eigen::Vector3d(0.1 + static_cast<double>(recording), 0.05, 0)) *
         Eigen::Vector3d(0, -kStandardGravity, 0);
}

inline InertialCalibrationInput inertial_views(const BoardRigScene& scene, std::uint64_t seed) {
  const Random random = random_of_run(20261201, seed);
  const Target target = april_board();
  const BoardMotion motion(scene.turning);
  InertialCalibrationInput input{.cameras = {.corners = target.corners(),
                                             .views = {},
                                             .cameras = {},
                                             .lenses = {},
                                             .shape = printed_shape(target)},
                                 .imu = {},
                                 .noise = scene.noise};
  const auto at = [](double t) { return Time(std::chrono::nanoseconds(std::llround(1e9 * t))); };
  std::uint64_t noise = 0;
  const auto normal = [&](Stream stream) {
    Eigen::Vector3d n;
    for (int i = 0; i < 3; ++i) n[i] = random.normal(stream, noise++);
    return n;
  };
  Eigen::Vector3d accelerometer_bias = 0.05 * normal(Stream::kAccelerometerBias);
  Eigen::Vector3d gyroscope_bias = 0.005 * normal(Stream::kGyroscopeBias);
  const double dt = 1 / scene.imu_rate, root = std::sqrt(dt);
  for (double t = 0; t < scene.seconds + 2; t += dt) {
    accelerometer_bias +=
        scene.noise.accelerometer_random_walk * root * normal(Stream::kAccelerometerWalk);
    gyroscope_bias += scene.noise.gyroscope_random_walk * root * normal(Stream::kGyroscopeWalk);
    const Eigen::Vector3d f =
        motion.target_T_imu(t).R.transpose() *
            (motion.acceleration(t) - true_gravity(scene.recording)) +
        accelerometer_bias +
        scene.noise.accelerometer_noise_density / root * normal(Stream::kAccelerometerNoise);
    const Eigen::Vector3d w =
        motion.rate_imu(t) + gyroscope_bias +
        scene.noise.gyroscope_noise_density / root * normal(Stream::kGyroscopeNoise);
    // What the IMU reads is what its corrections undo.
    const Eigen::Matrix3d I = Eigen::Matrix3d::Identity();
    ImuSample sample{.time = at(t)};
    sample.specific_force_imu = (I + scene.imu.force).inverse() * f;
    sample.angular_rate_imu = (I + scene.imu.rate).inverse() * w;
    input.imu.push_back(sample);
  }
  for (const Camera& camera : scene.cameras) {
    Camera size{.width = camera.width, .height = camera.height, .cam_T_imu = {}};
    size.shutter = camera.shutter;
    size.shutter.readout = 0;
    input.cameras.cameras.push_back(size);
    input.cameras.lenses.push_back(form_of(camera));
    input.has_readout |= camera.shutter.is_rolling();
  }
  for (double t = 1; t < scene.seconds + 1; t += 1 / scene.frame_rate) {
    for (std::size_t c = 0; c < scene.cameras.size(); ++c) {
      const Camera& camera = scene.cameras[c];
      TargetView view{.time = at(t - scene.time_offset),
                      .camera = static_cast<int>(c),
                      .ids = {},
                      .pixels = {}};
      for (std::size_t i = 0; i < input.cameras.corners.size(); ++i) {
        double delay = 0;
        std::optional<PixelProjection> image;
        for (int step = 0; step < 6; ++step) {
          const Eigen::Vector3d p_imu =
              motion.target_T_imu(t + delay).inverse() * input.cameras.corners[i];
          image = project(camera, camera.cam_T_imu * p_imu);
          if (!image || !in_image(camera, image->pixel, 2)) break;
          delay = line_delay(camera, image->pixel);
        }
        const Eigen::Vector2d error(random.normal(Stream::kPixelNoise, noise),
                                    random.normal(Stream::kPixelNoise, noise + 1));
        noise += 2;
        if (!image || !in_image(camera, image->pixel, 2)) continue;
        view.ids.push_back(static_cast<int>(i));
        view.pixels.push_back(image->pixel + scene.pixel_sigma * error);
      }
      if (view.ids.size() >= 20) input.cameras.views.push_back(std::move(view));
    }
  }
  return input;
}

/// True minus found, in the order of its layout.
inline Eigen::VectorXd inertial_errors(const InertialCalibration& found,
                                       const BoardRigScene& scene) {
  const InertialLayout& layout = found.layout;
  Eigen::VectorXd errors = Eigen::VectorXd::Zero(layout.rows());
  for (std::size_t c = 0; c < scene.cameras.size(); ++c) {
    const Camera &f = found.cameras[c], &t = scene.cameras[c];
    errors.segment(layout.lens_row(c), layout.lens(c).parameters()) =
        lens_parameters(t) - lens_parameters(f);
    errors.segment<3>(layout.pose_row(c)) = so3::log(t.cam_T_imu.R * f.cam_T_imu.R.transpose());
    errors.segment<3>(layout.pose_row(c) + 3) = t.cam_T_imu.p - f.cam_T_imu.p;
    errors[layout.offset_row(c)] = scene.time_offset - found.time_offsets[c];
    if (layout.has_readout()) errors[layout.readout_row(c)] = t.shutter.readout - f.shutter.readout;
  }
  for (std::size_t r = 0; r < found.gravity_target.size(); ++r) {
    const Eigen::Vector3d& gravity = found.gravity_target[r];
    const Eigen::Vector3d turn = so3::log(so3::between(gravity, true_gravity(r)));
    const Eigen::Vector3d first = gravity.unitOrthogonal();
    errors[layout.gravity_row(r)] = turn.dot(first);
    errors[layout.gravity_row(r) + 1] = turn.dot(gravity.normalized().cross(first));
  }
  if (found.imu.size() > 0) {
    ImuCorrection truth = scene.imu;
    truth.has_g_sensitivity = false;
    errors.segment(layout.imu_row(), found.imu.size()) =
        truth.parameters() - found.imu.parameters();
  }
  errors.tail(layout.shape_rows()) = -found.shape;
  return errors;
}

}  // namespace chasles::test
