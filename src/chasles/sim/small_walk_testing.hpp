#pragma once

#include <chasles/sim/inertial_settings.hpp>

namespace chasles::test {

/// A walk of some seconds with small images, which tests render in a second.
inline InertialScene small_walk() {
  InertialScene scene = inertial_scene("hallway");
  InertialSettings& s = scene.settings;
  s.hall_length = 8;
  s.hall_width = 6;
  s.sections = 1;
  s.rest_duration = 1;
  s.start_duration = 0.5;
  s.frame_rate = 15;
  s.focal_length = 200;
  s.image_width = 320;
  s.image_height = 240;
  s.center_u = 159.5;
  s.center_v = 119.5;
  return scene;
}

}  // namespace chasles::test
