#include <cmath>

#include <nlohmann/json.hpp>

#include "cli_test.hpp"

// Runs on a random part of the tracks.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

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

TEST(TracksPart, APairOfHalvesIsComparedWithoutATruth) {
  const Scratch folder;
  simulate(folder);
  const std::string run = "run rec --quiet --tracks 0.5 ";
  ASSERT_EQ(chasles(folder, run + "-o one").code, 0);
  const Outcome rest = chasles(folder, run + "--tracks-rest --json -o rest");
  expect_part(figures_of(rest).at("remarks").dump(),
              "the rest of a random part of the tracks: 0.5");
  const Json pair = figures_of(chasles(folder, "evaluate one rest --pair --json"));
  EXPECT_GT(pair.at("compared").get<int>(), 100);
  EXPECT_GT(pair.at("nees_count").get<int>(), pair.at("compared").get<int>() - 3);
  EXPECT_GT(pair.at("difference_m").get<double>(), 0);
  EXPECT_NEAR(pair.at("factor").get<double>(), std::sqrt(pair.at("nees_pose").get<double>() / 6),
              1e-9);
  EXPECT_FALSE(pair.at("overconfident").get<bool>()) << pair.dump();
  const Outcome text = chasles(folder, "evaluate one rest --pair");
  expect_part(text.out, "they differ by");
  expect_part(text.out, "the difference agrees with the covariances");
  expect_part(chasles(folder, "evaluate one rest --pair --markdown").out, "| difference |");
  expect_error(chasles(folder, "evaluate one one --pair"), 2, "equal at all times");
  expect_error(chasles(folder, "evaluate one --pair"), 1, "expected two run folders");
  EXPECT_EQ(chasles(folder, "evaluate one rest --pair").err, "");
  ASSERT_EQ(chasles(folder, run + "--tracks-seed 2 -o other").code, 0);
  expect_part(chasles(folder, "evaluate one other --pair").err, "the runs may share tracks");
  ASSERT_EQ(chasles(folder, "run rec --quiet --mode localize -o driven").code, 0);
  expect_error(chasles(folder, "evaluate one driven --pair"), 1,
               "driven: found a run with mode localize, expected slam");
  for (const std::string of_a_truth : {"--ate-below 1", "--truth-scale 2", "--pairing nearest"}) {
    expect_error(chasles(folder, "evaluate one rest --pair " + of_a_truth), 1, "--pair");
  }
  expect_error(chasles(folder, "run rec --tracks-rest"), 1, "--tracks");
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
