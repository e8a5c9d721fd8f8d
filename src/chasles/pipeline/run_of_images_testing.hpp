#pragma once

#include <atomic>

#include <gtest/gtest.h>

#include <chasles/pipeline/run.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/render_images.hpp>

namespace chasles::test {

// Images through the front end: on one thread and on three, and in real time.
class RunOfImages : public ::testing::Test {
 protected:
  static InertialScene walk_scene() {
    InertialScene scene = inertial_scene("hallway");
    InertialSettings& s = scene.settings;
    s.hall_length = 8;
    s.sections = 1;
    s.rest_duration = 1;
    s.frame_rate = 10;
    s.focal_length = 200;
    s.image_width = 320;
    s.image_height = 240;
    s.center_u = 159.5;
    s.center_v = 119.5;
    return scene;
  }
  static const Recording& walk() {
    static const Recording recording = render_inertial(walk_scene());
    return recording;
  }

  class Images : public RunObserver {
   public:
    void on_images(const ImageFrame&) override { ++images; }
    void on_unreadable(const InputError&) override { ++unreadable; }
    void on_estimate(const Estimate&, const EstimateTiming& timing) override {
      latencies += timing.latency.has_value();
      frontend_seconds += timing.frontend_seconds;
    }
    std::atomic<int> images = 0, unreadable = 0;
    int latencies = 0;
    double frontend_seconds = 0;
  };
};

}  // namespace chasles::test
