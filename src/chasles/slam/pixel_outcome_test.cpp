#include <cmath>
#include <map>
#include <set>

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <chasles/eval/chi2.hpp>
#include <chasles/lab/trial.hpp>
#include <chasles/sim/inertial_sim.hpp>
#include <chasles/slam/inertial_session.hpp>

// The outcomes of single observations, on a simulated scene.
namespace chasles {
namespace {

struct Seen {
  std::map<chasles::Outcome, int> outcomes;
  int expected = 0;    ///< observations with a prediction
  double squares = 0;  ///< of the innovations of used observations, by their own covariance
  int outside = 0;     ///< used, but outside the gate
  int frames = 0, estimates_used = 0, estimates_rejected = 0, estimates_added = 0;
  std::set<LandmarkId> initialised;
};

void count(std::span<const PixelOutcome> outcomes, Seen& seen) {
  static const double kGate = chi2_quantile(InertialSlamSettings{}.gate, 2);
  ++seen.frames;
  for (const PixelOutcome& one : outcomes) {
    ++seen.outcomes[one.outcome];
    if (one.outcome == chasles::Outcome::kInitialised)
      seen.initialised.insert(one.observation.landmark);
    EXPECT_FALSE(one.expected && one.outcome == chasles::Outcome::kWaiting);
    EXPECT_TRUE(one.expected || one.outcome != chasles::Outcome::kUsed);
    if (!one.expected) continue;
    ++seen.expected;
    const Eigen::Vector2d r = one.observation.pixel - one.expected->pixel;
    const double square = r.dot(one.expected->covariance.inverse() * r);
    if (one.outcome != chasles::Outcome::kUsed) continue;
    seen.squares += square;
    seen.outside += square > kGate ? 1 : 0;
  }
}

// In every tenth frame, the observations of one landmark are moved by `push` pixels.
Seen watch(double push) {
  InertialScene scene = inertial_scene("turntable");
  Recording recording = simulate_inertial(scene, 3);
  const InertialSlamSettings settings;
  InertialSession session(settings, {},
                          {.cameras = recording.cameras,
                           .noise = *recording.imu_noise,
                           .imu = {.convention = recording.imu_convention},
                           .pixel_sigma = recording.single_pixel_sigma.value_or(1)},
                          draw_start(recording, settings, 1, 3));
  Seen seen;
  session.set_observer(
      [&](const FeatureFrame&, std::span<const PixelOutcome> outcomes) { count(outcomes, seen); });
  EventStream events(recording);
  int number = 0;
  const auto add = [&](const std::vector<Estimate>& estimates) {
    for (const Estimate& e : estimates) {
      seen.estimates_used += e.used;
      seen.estimates_rejected += e.rejected;
      seen.estimates_added += e.added;
    }
  };
  while (auto event = events.next()) {
    if (const auto* sample = std::get_if<ImuSample>(&*event)) add(session.process(*sample));
    auto* frame = std::get_if<FeatureFrame>(&*event);
    if (!frame) continue;
    if (++number % 10 == 0 && !frame->pixels.empty()) frame->pixels.front().pixel.x() += push;
    add(session.process(*frame));
  }
  return seen;
}

TEST(PixelOutcomes, AreThoseOfTheEstimates) {
  Seen seen = watch(0);
  EXPECT_GT(seen.frames, 100);
  EXPECT_EQ(seen.outcomes[chasles::Outcome::kUsed], seen.estimates_used);
  EXPECT_EQ(seen.outcomes[chasles::Outcome::kRejected], seen.estimates_rejected);
  EXPECT_EQ(std::ssize(seen.initialised), seen.estimates_added) << "one camera, each begins once";
  EXPECT_GT(seen.outcomes[chasles::Outcome::kWaiting], 0);
  EXPECT_EQ(seen.outside, 0);
}

// Each square is the sum of two squared components of unit variance if the filter is consistent.
// The mean is 2, within the scatter of some thousands of values that are correlated between frames.
TEST(PixelOutcomes, TheirCovariancesAreThoseOfTheirInnovations) {
  Seen seen = watch(0);
  ASSERT_GT(seen.outcomes[chasles::Outcome::kUsed], 2000);
  EXPECT_NEAR(seen.squares / seen.outcomes[chasles::Outcome::kUsed], 2, 0.15);
}

TEST(PixelOutcomes, AGrossErrorIsRejectedWhereItWasExpected) {
  const Seen clean = watch(0), pushed = watch(60);
  EXPECT_GT(pushed.outcomes.at(chasles::Outcome::kRejected),
            clean.outcomes.at(chasles::Outcome::kRejected) + pushed.frames / 40);
}

}  // namespace
}  // namespace chasles
