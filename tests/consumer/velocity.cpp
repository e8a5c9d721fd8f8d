#include <cstdio>

#include <chasles/pipeline/run.hpp>
#include <chasles/sim/street.hpp>
#include <chasles/slam/velocity_slam.hpp>

/// SLAM over a simulated street; succeeds if the end is where the truth says, to within 5 m.
int main() {
  const chasles::Recording recording = chasles::simulate_street({.route = "LS"});

  const chasles::VelocitySlamSettings settings;
  const auto noise = chasles::choose_noise(settings, recording.velocities, recording.frames, {});
  chasles::VelocitySlam slam(settings, recording.rig, noise);
  chasles::Estimate estimate;
  chasles::EventStream events(recording);  // of a robot: what its drivers deliver, as it comes
  while (const auto event = events.next()) {
    if (const auto* velocity = std::get_if<chasles::BodyVelocity>(&*event)) {
      slam.process(*velocity);
    } else if (const auto* frame = std::get_if<chasles::FeatureFrame>(&*event)) {
      estimate = slam.process(*frame);
    }
  }

  const double error = (estimate.world_T_imu.p - recording.truth.back().pose.p).norm();
  std::printf("%d landmarks, %.2f m from the truth\n", estimate.landmarks, error);

  // The same by one call.
  const auto run = chasles::run(recording, chasles::VelocityRunSettings{});
  const bool same = run.estimates.back().world_T_imu.p == estimate.world_T_imu.p;
  return error < 5 && same ? 0 : 1;
}
