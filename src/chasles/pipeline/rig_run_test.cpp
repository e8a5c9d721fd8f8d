#include <functional>
#include <memory>
#include <utility>

#include <gtest/gtest.h>

#include <chasles/lie/trajectory.hpp>
#include <chasles/pipeline/run.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/render_images.hpp>
#include <chasles/slam/inertial_session_testing.hpp>

// Runs from the images of a ring of four cameras that see nothing in common.
namespace chasles {
namespace {

using test::error_from;

const Recording& ring_walk() {
  static const Recording recording = [] {
    InertialScene scene = inertial_scene("hallway");
    InertialSettings& s = scene.settings;
    s.cameras = 4;
    s.rig = RigLayout::kRing;
    s.hall_length = 8;
    s.sections = 1;
    s.rest_duration = 1.5;
    s.frame_rate = 10;
    s.focal_length = 170;
    s.image_width = 240;
    s.image_height = 180;
    s.center_u = 119.5;
    s.center_v = 89.5;
    return render_inertial(scene);
  }();
  return recording;
}

/// Whether a camera has its image in a frame.
using HasImage = std::function<bool(std::size_t frame, std::size_t camera)>;

class SomeImages : public ImageSource {
 public:
  SomeImages(std::shared_ptr<const ImageSource> images, HasImage has)
      : images_(std::move(images)), has_(std::move(has)) {}
  std::size_t size() const override { return images_->size(); }
  Time time(std::size_t i) const override { return images_->time(i); }
  ImageFrame read(std::size_t i) const override {
    ImageFrame frame = images_->read(i);
    for (std::size_t c = 0; c < frame.images.size(); ++c) {
      if (!has_(i, c)) frame.images[c] = {};
    }
    return frame;
  }

 private:
  std::shared_ptr<const ImageSource> images_;
  HasImage has_;
};

RunResult run_with(const HasImage& has, const InertialRunSettings& settings = {}) {
  Recording recording = ring_walk();
  recording.images = std::make_shared<SomeImages>(ring_walk().images, has);
  return run(recording, settings, {.threads = 1});
}

TEST(RunOfARig, OfFourCamerasWithoutOverlapIsAccurate) {
  const RunResult result = run_with([](std::size_t, std::size_t) { return true; });
  EXPECT_GT(result.estimates.size(), ring_walk().images->size() * 8 / 10);
  EXPECT_LT(error_from(result.estimates, ring_walk()), 0.1);
  ASSERT_EQ(result.report.frontend.added_by_camera.size(), 4u);
  for (const long added : result.report.frontend.added_by_camera) EXPECT_GT(added, 40);
}

TEST(RunOfARig, WhoseCamerasTakeTurnsHasAnEstimateAtEachImage) {
  const RunResult result = run_with([](std::size_t i, std::size_t c) { return i % 4 == c; });
  EXPECT_GT(result.estimates.size(), ring_walk().images->size() * 8 / 10);
  EXPECT_LT(error_from(result.estimates, ring_walk()), 0.25);
}

TEST(RunOfARig, GoesOnWhileTheFirstCameraHasNoImage) {
  const auto has = [](std::size_t i, std::size_t c) { return c > 0 || i < 30 || i > 60; };
  for (const char* estimator : {"filter", "window:10", "batch"}) {
    InertialRunSettings settings;
    settings.estimator = estimator_choice(estimator);
    const RunResult result = run_with(has, settings);
    EXPECT_GT(result.estimates.size(), ring_walk().images->size() * 4 / 10) << estimator;
    EXPECT_LT(error_from(result.estimates, ring_walk()), 0.15) << estimator;
  }
}

TEST(RunOfARig, StartsAndRunsWithoutAnyImageOfTheFirstCamera) {
  InertialRunSettings settings;
  settings.filter.recognise = Recognise::kAppearance;  // by the first camera's images
  const RunResult result = run_with([](std::size_t, std::size_t c) { return c > 0; }, settings);
  EXPECT_GT(result.estimates.size(), ring_walk().images->size() * 8 / 10);
  EXPECT_LT(error_from(result.estimates, ring_walk()), 0.15);
}

}  // namespace
}  // namespace chasles
