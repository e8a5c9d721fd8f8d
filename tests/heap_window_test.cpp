#include <optional>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/lab/batch_trial.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/sim/street.hpp>
#include <chasles/smooth/window/velocity_window.hpp>
#include <chasles/velocity/velocity_noise.hpp>

#include "heap_count.hpp"

// Heap use of a sliding window for states that it has marginalised.
namespace chasles::test {
namespace {

struct WindowCost {
  int frames = 0;
  long live_bytes = 0, landmarks = 0;
};

/// Over the frames from the hundredth on, when all lists have their capacity.
class Growth {
 public:
  void frame(long landmarks) {
    if (++frames_ == 100) early_ = now(landmarks);
    late_ = now(landmarks);
  }

  // Only the map may grow, by its landmarks; its container may have twice the capacity. A keyframe
  // with its samples takes about 3 kB. The matrices depend on the number of landmarks in view.
  void check(int frames) const {
    ASSERT_EQ(late_.frames, frames);
    EXPECT_GT(late_.landmarks, 2 * early_.landmarks);
    const long map = 2 * late_.landmarks * static_cast<long>(sizeof(MapLandmark));
    const long grown = late_.live_bytes - early_.live_bytes;
    EXPECT_LT(grown, map + kRoom);
    testing::Test::RecordProperty("grown_bytes", static_cast<int>(grown));
    testing::Test::RecordProperty("landmarks", static_cast<int>(late_.landmarks));
  }

 private:
  static constexpr long kRoom = 500'000;
  WindowCost now(long landmarks) const {
    return {.frames = frames_, .live_bytes = heap_count().live_bytes, .landmarks = landmarks};
  }

  int frames_ = 0;
  WindowCost early_, late_;
};

TEST(WindowHeap, WithAnImuGrowsByTheMapAlone) {
  if (!heap_is_counted()) GTEST_SKIP() << "skipped: the sanitizers have a heap of their own";
  InertialScene scene = inertial_scene("hallway");
  scene.settings.frame_rate = 10;
  const Recording recording = simulate_inertial(scene);
  const InertialSlamSettings settings;
  InertialWindow window(batch_input(recording, settings, draw_start(recording, settings, 0, 0)),
                        settings.chart, BatchSettings{}, 5);
  Growth growth;
  const auto take = [&](const std::vector<Estimate>& motions) {
    for (const Estimate& motion : motions) growth.frame(motion.landmarks);
  };
  EventStream stream(recording);
  while (auto event = stream.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) take(window.process(*sample));
    if (const auto* frame = std::get_if<FeatureFrame>(&*event)) take(window.process(*frame));
  }
  take(window.finish());
  growth.check(static_cast<int>(recording.frames.size()));
}

TEST(WindowHeap, WithBodyVelocitiesGrowsByTheMapAlone) {
  if (!heap_is_counted()) GTEST_SKIP() << "skipped: the sanitizers have a heap of their own";
  StreetSettings street = street_scene("street");
  street.features_per_frame = 20;
  street.velocities_per_frame = 4;
  const Recording recording = simulate_street(street);
  const VelocitySlamSettings settings;
  const VelocitySlamNoise noise =
      choose_noise(settings, recording.velocities, recording.frames,
                   {.velocity = recording.velocity_sigma, .pixels = recording.pixel_sigma});
  VelocityWindow window(
      {.rig = recording.rig, .settings = settings, .noise = noise, .velocities = {}, .frames = {}},
      {}, 3);
  Growth growth;
  EventStream stream(recording);
  while (auto event = stream.next()) {
    if (const auto* velocity = std::get_if<BodyVelocity>(&*event)) window.process(*velocity);
    const auto* frame = std::get_if<FeatureFrame>(&*event);
    if (!frame) continue;
    const std::optional<Estimate> estimate = window.process(*frame);
    ASSERT_TRUE(estimate);
    growth.frame(estimate->landmarks);
  }
  growth.check(static_cast<int>(recording.frames.size()));
}

}  // namespace
}  // namespace chasles::test
