#include <cstdio>

#include <chasles/eval/ate.hpp>
#include <chasles/pipeline/visual_inertial_slam.hpp>
#include <chasles/sim/render_images.hpp>

/// SLAM from the images and the IMU of a simulated walk, event by event. Succeeds if the position
/// error (RMSE) is below 10 cm.
int main() {
  chasles::InertialScene scene = chasles::inertial_scene("hallway");
  scene.settings.hall_length = 8;
  scene.settings.sections = 1;
  scene.settings.rest_duration = 1;
  scene.settings.frame_rate = 15;
  const chasles::Recording walk = chasles::render_inertial(scene);

  chasles::VisualInertialSlam slam(walk.cameras, *walk.imu_noise);
  chasles::Trajectory trajectory;
  const auto take = [&](const std::vector<chasles::Estimate>& estimates) {
    for (const auto& e : estimates) trajectory.push_back({e.time, e.world_T_imu});
  };
  chasles::EventStream events(walk);  // on a robot: the events of its drivers
  while (const auto event = events.next()) {
    if (const auto* sample = std::get_if<chasles::ImuSample>(&*event)) {
      take(slam.process(*sample));
    } else if (const auto* images = std::get_if<chasles::ImagesDue>(&*event)) {
      take(slam.process(walk.images->read(images->index)));
    }
  }
  take(slam.finish());
  if (trajectory.empty()) std::puts(slam.estimator().why_not_started().c_str());

  const auto matched = chasles::associate(trajectory, walk.truth);
  const double error =
      chasles::absolute_error(matched, chasles::Alignment::kPositionYaw).position_m.rmse;
  std::printf("%zu estimates, %.3f m from the truth\n", trajectory.size(), error);
  return error < 0.1 ? 0 : 1;
}
