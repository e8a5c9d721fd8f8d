#pragma once

#include <chasles/sim/inertial_sim.hpp>

// Shared by the tests of inertial_sim.hpp.
namespace chasles::test {

inline constexpr double kSigmas = 4;  // of the statistic under test; the seeds are fixed

// Starts from a standstill; has landmarks nearby as well.
inline InertialScene hallway() {
  InertialScene scene = inertial_scene("hallway");
  scene.settings.rest_duration = 1;
  scene.settings.start_duration = 1.5;
  scene.settings.min_range = 0.8;
  return scene;
}

inline const Recording& walk() {
  static const Recording recording = simulate_inertial(hallway());
  return recording;
}

}  // namespace chasles::test
