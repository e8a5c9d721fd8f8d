#include <optional>
#include <variant>

#include <chasles/base/overloaded.hpp>
#include <chasles/session/dead_reckoning.hpp>
#include <chasles/velocity/velocity_slam.hpp>

namespace chasles {

Trajectory dead_reckoning(const Recording& recording) {
  VelocitySlamSettings settings;
  settings.mode = SlamMode::kLocalize;
  settings.velocity = VelocityRole::kInput;
  settings.hold = VelocityHold::kMidpoint;
  VelocitySlam slam(settings, recording.rig, VelocitySlamNoise{});
  Trajectory trajectory;
  EventStream events(recording);
  bool lost = false;
  while (const auto event = lost ? std::nullopt : events.next()) {
    std::visit(Overloaded{[&](const BodyVelocity& velocity) { slam.process(velocity); },
                          [&](const FeatureFrame& frame) {
                            const Estimate e = slam.process(frame);
                            lost = e.health == Health::kLost;
                            if (!lost)
                              trajectory.push_back({.time = e.time, .pose = e.world_T_imu});
                          },
                          [](const auto& /*other*/) {}},
               *event);
  }
  return trajectory;
}

}  // namespace chasles
