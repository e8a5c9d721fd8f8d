#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include <nlohmann/json.hpp>

#include <chasles/pipeline/tracks_part.hpp>

#include "cli_test.hpp"

// Runs on a random part of the tracks.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

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

double observations(const Json& summary) { return summary.at("observations").get<double>(); }

Json figures_of(const Outcome& outcome) {
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  return Json::parse(outcome.out);
}

TEST(TracksPart, IsWhatARunSeesAndSays) {
  const Scratch folder;
  simulate(folder);
  const Json all = figures_of(chasles(folder, "run rec --json --quiet"));
  for (const char* estimator : {"filter", "batch", "window:5"}) {
    const std::string run = std::string("run rec --json --quiet --tracks 0.5 --estimator ");
    const Json half = figures_of(chasles(folder, run + estimator));
    EXPECT_NEAR(observations(half) / observations(all), 0.5, 0.15) << estimator;
    expect_part(half.at("remarks").dump(), "0.5 of all, seed 1");
    const Json other = figures_of(chasles(folder, run + estimator + " --tracks-seed 2"));
    EXPECT_NE(other.at("ate_m"), half.at("ate_m")) << estimator;
  }
  expect_error(chasles(folder, "run rec --tracks 1.5"), 1, "--tracks: found 1.5, expected");
  for (const std::string wrong : {"-1", "1.5", "many"}) {
    expect_error(chasles(folder, "run rec --tracks 0.5 --tracks-seed=" + wrong), 1,
                 "--tracks-seed: found " + wrong + ", expected a whole number from 0 on");
  }
}

// The tracks of the front end are thinned after it.
TEST(TracksPart, OfImagesIsOfWhatTheFrontEndFollows) {
  const Scratch folder;
  ASSERT_EQ(chasles(folder,
                    "simulate walk --images --quiet -o rec --set walk_duration=6 --set "
                    "image_width=160 --set image_height=120 --set focal_length=100 --set "
                    "center_u=79.5 --set center_v=59.5 --set texel_size=0.05 --set frame_rate=10")
                .code,
            0);
  const std::string run = "run rec --json --quiet --begin truth ";
  const Json all = figures_of(chasles(folder, run)),
             half = figures_of(chasles(folder, run + "--tracks 0.5"));
  EXPECT_NEAR(observations(half) / observations(all), 0.5,
              0.27);  // three sigma of about thirty long tracks
}

}  // namespace
}  // namespace chasles::test
