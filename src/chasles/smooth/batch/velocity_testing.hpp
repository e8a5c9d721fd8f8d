#pragma once

#include <algorithm>
#include <map>

#include <Eigen/Cholesky>

#include <chasles/filter/simulated_drive_testing.hpp>
#include <chasles/smooth/batch/velocity_batch.hpp>
#include <chasles/velocity/velocity_model.hpp>

// A short simulated run past a few points, whose motion is drawn from the estimator's own model,
// for tests.
namespace chasles::test {

struct SmallDrive {
  int frames = 8;
  double noise = 1;  ///< factor on the drawn noise; the estimator assumes 1
  VelocityRole velocity = VelocityRole::kMeasured;
  bool scale = false;
  bool level = false;
  StereoRows rows = StereoRows::kMeanDisparity;
  int samples_a_frame = 1;
  int landmarks = 20;
  std::uint64_t seed = 1;
};

struct TrueDrive {
  Time time{};
  SE3 world_T_imu;
  Eigen::VectorXd additive;
};

struct DriveScene {
  VelocityBatchInput input;
  std::vector<TrueDrive> truth;  ///< of every frame
  std::map<LandmarkId, Eigen::Vector3d> landmarks;
};

inline VelocitySlamNoise small_drive_noise() {
  VelocitySlamNoise noise;
  noise.motion.sample_sigma << 0.01, 0.01, 0.01, 0.1, 0.1, 0.1;
  noise.motion.walk << 0.1, 0.1, 0.1, 0.5, 0.3, 0.3;
  noise.motion.gyro_bias_walk = 1e-3;
  noise.motion.scale_walk = 1e-3;
  noise.motion.tilt_walk = 1e-3;
  noise.motion.heading_walk = 2e-3;
  noise.gyro_bias_sigma = 0.02;
  noise.initialisation = noise.update = {.u = 0.5, .v = 0.5, .disparity = 0.5};
  noise.update.disparity = 0.7;
  return noise;
}

namespace drive_scene_detail {

// One interval: the true motion and the sample at its end.
struct Draw {
  Random& random;
  double noise;
  Eigen::Vector3d normal3(double sigma) { return noise * sigma * random.normal_vector(3); }
  Vector6d normal6(const Vector6d& sigma) {
    return noise * sigma.cwiseProduct(random.normal_vector(6));
  }
};

inline void observe(const SmallDrive& drive, const SE3& world_T_imu, Time time, Draw& draw,
                    DriveScene& scene) {
  const VelocityBatchInput& in = scene.input;
  FeatureFrame frame{.time = time};
  for (const auto& [id, p] : scene.landmarks) {
    const Eigen::Vector3d p_cam0 = in.rig.cam0_T_imu * (world_T_imu.inverse() * p);
    const auto seen = project(in.rig, p_cam0);
    if (!seen || p_cam0.z() < 3) continue;
    const bool first = std::ranges::none_of(in.frames, [&, id = id](const FeatureFrame& f) {
      return std::ranges::find(f.observations, id, &StereoObservation::landmark) !=
             f.observations.end();
    });
    const StereoNoise& sigma = first ? in.noise.initialisation : in.noise.update;
    // Independent in the rows of the measurement; vL - vR is not one of them.
    Eigen::Vector4d e = Eigen::Vector4d::Zero();
    if (drive.rows == StereoRows::kAll && !first) {
      e = draw.noise * sigma.u * draw.random.normal_vector(4);
    } else {
      const Eigen::Vector3d n = draw.noise * draw.random.normal_vector(3);
      const double u = sigma.u * n[0], half = sigma.disparity * n[2] / 2;
      e << u + half, sigma.v * n[1], u - half, sigma.v * n[1];
    }
    frame.observations.push_back({.landmark = id, .pixels = seen->pixels + e});
  }
  scene.input.frames.push_back(frame);
}

// Body axes to level ones, by yaw, pitch and roll.
inline void make_level(const Eigen::Matrix3d& world_R_imu, const Eigen::Vector3d& tilt_heading,
                       Vector6d& u) {
  const Eigen::Matrix3d nav_R_imu =
      so3::exp(Eigen::Vector3d(tilt_heading[0], tilt_heading[1], 0)) * world_R_imu;
  const double yaw = std::atan2(nav_R_imu(1, 0), nav_R_imu(0, 0));
  const Eigen::Matrix3d sample_R_imu =
      so3::exp((tilt_heading[2] - yaw) * Eigen::Vector3d::UnitZ()) * nav_R_imu;
  u.head<3>() = (sample_R_imu * u.head<3>()).eval();
  u.tail<3>() = (sample_R_imu * u.tail<3>()).eval();
}

}  // namespace drive_scene_detail

inline DriveScene drive_scene(const SmallDrive& drive = {}) {
  using namespace drive_scene_detail;
  Random random(drive.seed);
  Draw draw{random, drive.noise};
  DriveScene scene;
  VelocityBatchInput& in = scene.input;
  in.rig = drive_rig();
  in.noise = small_drive_noise();
  in.settings.velocity = drive.velocity;
  in.settings.velocity_scale = drive.scale;
  in.settings.velocity_scale_sigma = 0.05;
  in.settings.velocity_relative_sigma = 0;
  in.settings.stereo_rows = drive.rows;
  in.settings.hold = VelocityHold::kZeroOrder;
  in.settings.tilt_sigma = in.settings.velocity_heading_sigma = 0.05;
  in.noise.level_velocities = drive.level;
  const BodyVelocityModel model = model_of(in.settings, in.noise);
  const BodyVelocityNoise& noise = in.noise.motion;
  const double tau = kDriveStep / drive.samples_a_frame;

  TrueDrive now{.time = std::chrono::seconds(100), .world_T_imu = {}, .additive = {}};
  Vector6d v;
  v << 0.02, -0.03, 0.25, 6, 0.1, 0.05;
  Eigen::Vector3d bias = draw.normal3(in.noise.gyro_bias_sigma);
  double log_scale =
      drive.scale ? drive.noise * in.settings.velocity_scale_sigma * random.normal() : 0;
  Eigen::Vector3d tilt_heading = Eigen::Vector3d::Zero();
  if (drive.level) tilt_heading = draw.normal3(in.settings.tilt_sigma);
  for (int i = 0; i < drive.landmarks; ++i) {
    scene.landmarks[100 + i] = {random.uniform(8, 25), random.uniform(-6, 6),
                                random.uniform(-2, 3)};
  }
  for (int k = 0; k <= (drive.frames - 1) * drive.samples_a_frame; ++k) {
    // The sample measures the present velocity; as an input it then moves the pose, with its noise.
    Vector6d u = v;
    u.tail<3>() *= std::exp(log_scale);
    if (drive.level) make_level(now.world_T_imu.R, tilt_heading, u);
    u.head<3>() += bias;
    const Vector6d sampled = u + draw.normal6(noise.sample_sigma);
    in.velocities.push_back(
        {.time = now.time, .linear_imu = sampled.tail<3>(), .angular_imu = sampled.head<3>()});
    now.additive.resize(model.size());
    if (model.velocity_state) now.additive.head<6>() = v;
    now.additive.segment<3>(model.bias_index()) = bias;
    if (model.scale) now.additive[model.scale_index()] = log_scale;
    if (model.level) now.additive.segment<3>(model.tilt_index()) = tilt_heading;
    if (k % drive.samples_a_frame == 0) {
      scene.truth.push_back(now);
      observe(drive, now.world_T_imu, now.time, draw, scene);
    }
    Vector6d xi = tau * v;
    if (model.velocity_state) {
      // The integral of white noise, and the integral of that.
      const Vector6d a = draw.normal6(noise.walk), b = draw.normal6(noise.walk);
      xi += std::sqrt(tau * tau * tau) * (a / 2 + b / std::sqrt(12.0));
      v += std::sqrt(tau) * a;
    }
    now.world_T_imu = now.world_T_imu * se3::exp(xi);
    now.time += from_seconds(tau);
    bias += draw.normal3(std::sqrt(tau) * noise.gyro_bias_walk);
    if (drive.level) {
      const Eigen::Vector3d walk(noise.tilt_walk, noise.tilt_walk, noise.heading_walk);
      tilt_heading += draw.normal3(std::sqrt(tau)).cwiseProduct(walk);
    }
    if (drive.scale) log_scale += drive.noise * std::sqrt(tau) * noise.scale_walk * random.normal();
  }
  return scene;
}

/// [rotation, position, additive], reference chart.
inline Eigen::VectorXd drive_error(const TrueDrive& truth, const Estimate& e) {
  Eigen::VectorXd d(6 + e.additive.size());
  d << so3::log(truth.world_T_imu.R * e.world_T_imu.R.transpose()),
      truth.world_T_imu.p - e.world_T_imu.p, truth.additive - e.additive;
  return d;
}

}  // namespace chasles::test
