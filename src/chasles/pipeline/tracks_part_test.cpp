#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include <gtest/gtest.h>

#include <chasles/pipeline/tracks_part.hpp>

namespace chasles {
namespace {

constexpr LandmarkId kTracks = 10000;

// Each track, as observed by a stereo pair and by a single camera.
FeatureFrame frame_of_all() {
  FeatureFrame frame;
  for (LandmarkId id = 0; id < kTracks; ++id) {
    frame.observations.push_back({.landmark = id});
    frame.pixels.push_back({.landmark = id});
  }
  return frame;
}

std::vector<LandmarkId> used(const TracksPart& part) {
  FeatureFrame frame = frame_of_all();
  part.thin(frame);
  std::vector<LandmarkId> observations, pixels;
  for (const StereoObservation& o : frame.observations) observations.push_back(o.landmark);
  for (const PixelObservation& o : frame.pixels) pixels.push_back(o.landmark);
  EXPECT_EQ(observations, pixels);
  return observations;
}

TEST(TracksPart, UsesATrackWithTheProbabilityThatIsAskedForOrAll) {
  EXPECT_EQ(used({}).size(), kTracks);
  EXPECT_EQ(used({.part = 1}).size(), kTracks);
  EXPECT_EQ(used({.part = 0}).size(), 0u);
  for (const double part : {0.1, 0.5, 0.9}) {
    const double sigma = std::sqrt(kTracks * part * (1 - part));
    EXPECT_NEAR(static_cast<double>(used({.part = part}).size()), part * kTracks, 3 * sigma);
  }
}

TEST(TracksPart, OfOneSeedIsIndependentOfThatOfAnother) {
  const std::vector<LandmarkId> one = used({.part = 0.5, .seed = 1}),
                                other = used({.part = 0.5, .seed = 2});
  EXPECT_EQ(one, used({.part = 0.5, .seed = 1}));
  std::vector<LandmarkId> both;
  std::ranges::set_intersection(one, other, std::back_inserter(both));
  EXPECT_NEAR(static_cast<double>(both.size()), kTracks / 4.0, 3 * std::sqrt(kTracks * 3 / 16.0));
}

TEST(TracksPart, ItsRestHasTheOtherTracks) {
  const std::vector<LandmarkId> one = used({.part = 0.3, .seed = 4}),
                                rest = used({.part = 0.3, .seed = 4, .rest = true});
  std::vector<LandmarkId> both, all;
  std::ranges::set_intersection(one, rest, std::back_inserter(both));
  std::ranges::set_union(one, rest, std::back_inserter(all));
  EXPECT_TRUE(both.empty());
  EXPECT_EQ(all.size(), kTracks);
}

}  // namespace
}  // namespace chasles
