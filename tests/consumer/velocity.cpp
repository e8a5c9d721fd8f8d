#include <cstdio>
#include <variant>

#include <chasles/sim/street.hpp>
#include <chasles/velocity/velocity_slam.hpp>

/// SLAM along a simulated street. Succeeds if the final position is within 5 m of the truth.
int main() {
  const chasles::Recording recording = chasles::simulate_street({.route = "LS"});

  const chasles::VelocitySlamSettings settings;
  const auto noise = chasles::choose_noise(settings, recording.velocities, recording.frames, {});
  chasles::VelocitySlam slam(settings, recording.rig, noise);
  chasles::Estimate estimate;
  chasles::EventStream events(recording);  // on a robot: the events of its drivers
  while (const auto event = events.next()) {
    if (const auto* velocity = std::get_if<chasles::BodyVelocity>(&*event)) {
      slam.process(*velocity);
    } else if (const auto* frame = std::get_if<chasles::FeatureFrame>(&*event)) {
      estimate = slam.process(*frame);
    }
  }

  const double error = (estimate.world_T_imu.p - recording.truth.back().pose.p).norm();
  std::printf("%d landmarks, %.2f m from the truth\n", estimate.landmarks, error);
  return error < 5 ? 0 : 1;
}
