#include <cstdio>
#include <variant>

#include <chasles/data/recording.hpp>
#include <chasles/sim/street.hpp>
#include <chasles/slam/velocity_slam.hpp>

/// SLAM over a simulated drive; succeeds if the end is where the truth says, to within 5 m.
int main() {
  const chasles::Recording drive = chasles::simulate_street({.route = "LS"});

  const chasles::VelocitySlamSettings settings;
  const auto noise = chasles::choose_noise(settings, drive.velocities, drive.frames, {});
  chasles::VelocitySlam slam(settings, drive.rig, noise);
  chasles::Estimate estimate;
  chasles::EventStream events(drive);
  while (const auto event = events.next()) {
    if (const auto* velocity = std::get_if<chasles::BodyVelocity>(&*event)) {
      slam.process(*velocity);
    } else {
      estimate = slam.process(std::get<chasles::FeatureFrame>(*event));
    }
  }

  const double error = (estimate.world_T_imu.p - drive.truth.back().pose.p).norm();
  std::printf("%d landmarks, %.2f m from the truth\n", estimate.landmarks, error);
  return error < 5 ? 0 : 1;
}
