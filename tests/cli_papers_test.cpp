#include <cmath>
#include <cstdlib>

#include <nlohmann/json.hpp>

#include <chasles/recording/readers.hpp>

#include "cli_test.hpp"

// The findings of the two founding papers, with the configurations that are named after them.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

std::filesystem::path drives_of_du() {
  const char* set = std::getenv("CHASLES_DATA");
  return (set ? std::filesystem::path(set)
              : std::filesystem::path(CHASLES_SOURCE_DIR) / "../shared/data") /
         "kitti_tracks";
}

class DuOnHisRecordings : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(drives_of_du())) GTEST_SKIP() << "skipped: no recordings";
  }

  // The figures of a run of his test with one of his parameter sets.
  static Json run(const std::string& test, const std::string& options) {
    const Scratch folder;
    const std::string data = drives_of_du().string();
    const Outcome outcome =
        chasles(folder, "run " + data + "/ece276a_2018/" + test + ".npz --truth " + data +
                            "/ground_truth/" + test + "_gt_imu_stars.tum --json --quiet --config " +
                            CHASLES_SOURCE_DIR "/studies/configs/" + options);
    EXPECT_TRUE(outcome.code == 0 || outcome.code == 4) << outcome.err;
    return Json::parse(outcome.out);
  }
  static double ate(const std::string& test, const std::string& options) {
    return run(test, options)["ate_m"].get<double>();
  }
};

// Du, section IV: set 1 is good on all three tests. Dead reckoning errs by 0.7 to 2.9 m.
TEST_F(DuOnHisRecordings, ParameterSet1IsGoodOnAllThree) {
  for (const char* test : {"0020", "0027", "0042"}) {
    EXPECT_LT(ate(test, "du-set1.yaml"), 10) << test;
  }
}

// Set 2 is good on test 27; on tests 20 and 42 the trajectory twists.
TEST_F(DuOnHisRecordings, ParameterSet2TwistsTests20And42) {
  EXPECT_LT(ate("0027", "du-set2.yaml"), 10);
  EXPECT_GT(ate("0020", "du-set2.yaml"), 50);
  EXPECT_GT(ate("0042", "du-set2.yaml"), 20);
}

// Not moving objects, as he supposed, but stale pixels twist test 20.
TEST_F(DuOnHisRecordings, WithoutStalePixelsSet2IsGoodOnTest20) {
  EXPECT_LT(ate("0020", "du-set2.yaml --set reader.stale_pixels=cut"), 10);
}

// Figures 4 to 6: V = 10 I and 1000 I give similar maps.
TEST_F(DuOnHisRecordings, TheMappingUpdateKeepsTheInitialPositions) {
  const Scratch folder;
  const Outcome outcome =
      chasles(folder, "run " + drives_of_du().string() + "/ece276a_2018/0020.npz --quiet -o run " +
                          "--config " + CHASLES_SOURCE_DIR "/studies/configs/du-task2-v10.yaml");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::string landmarks = slurp(folder / "run/landmarks.csv");
  expect_part(landmarks.substr(0, landmarks.find('\n')), "initial_x,initial_y,initial_z");
}

Json data_of_page(const std::string& page) {
  const std::string opening = R"(id="report-data">)";
  const std::size_t from = page.find(opening) + opening.size();
  return Json::parse(page.substr(from, page.find("</script", from) - from));
}

// Kleinert & Stilla's figure 4: a walk that has a floor plan and no truth, in their filter, from a
// heading by compass and a position on the plan. Here the true walk is known, and begins there.
TEST(KleinertStilla, AWalkWithoutATruthLiesOnThePlan) {
  const Scratch folder;
  ASSERT_EQ(chasles(folder, "simulate walk --set walk_duration=12 -o rec").code, 0);
  const Trajectory truth = read_tum(folder / "rec/truth.tum");
  for (const char* file : {"truth.tum", "landmarks_truth.csv", "true_motion.csv"}) {
    std::filesystem::remove(folder / "rec" / file);
  }
  for (const std::string chart : {"standard", "left-se3", "right-se3"}) {
    const Outcome done =
        chasles(folder, "run rec --quiet --config " CHASLES_SOURCE_DIR
                        "/studies/configs/kleinert-stilla.yaml --set start.heading=0.03 --chart " +
                            chart + " -o " + chart);
    ASSERT_EQ(done.code, 0) << done.err;
    const Trajectory path = read_tum(folder / chart / "trajectory.tum");
    const Eigen::Vector3d end = path.back().pose.p, expected = truth.back().pose.p;
    EXPECT_GT(expected.norm(), 5);
    EXPECT_LT((end - expected).norm(), 0.5) << chart;
  }
  ASSERT_EQ(chasles(folder, "report standard left-se3 right-se3 -o page.html").code, 0);
  const Json data = data_of_page(slurp(folder / "page.html"));
  for (const Json& run : data["runs"]) EXPECT_TRUE(run.contains("plan"));
  ASSERT_EQ(data["scenes"].size(), 1u);
  EXPECT_EQ(data["scenes"][0]["runs"].size(), 3u);
  EXPECT_FALSE(data["scenes"][0].contains("truth"));
}

}  // namespace
}  // namespace chasles::test
