#include <cstdlib>

#include <nlohmann/json.hpp>

#include "cli_test.hpp"

// The findings of the two founding papers, with the configurations that are named after them.
namespace chasles::test {
namespace {

using Json = nlohmann::json;

std::filesystem::path recordings() {
  const char* set = std::getenv("CHASLES_DATA");
  return (set ? std::filesystem::path(set)
              : std::filesystem::path(CHASLES_SOURCE_DIR) / "../shared/data") /
         "kitti_tracks";
}

class DuOnHisRecordings : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(recordings())) GTEST_SKIP() << "skipped: no recordings";
  }

  // The figures of a run of his test with one of his parameter sets.
  static Json run(const std::string& test, const std::string& options) {
    const Scratch folder;
    const std::string data = recordings().string();
    const Outcome outcome =
        chasles(folder, "run " + data + "/ece276a_2018/" + test + ".npz --truth " + data +
                            "/ground_truth/" + test + "_gt_imu_stars.tum --json --quiet --config " +
                            CHASLES_SOURCE_DIR "/configs/" + options);
    EXPECT_TRUE(outcome.code == 0 || outcome.code == 4) << outcome.err;
    return Json::parse(outcome.out);
  }
  static double ate(const std::string& test, const std::string& options) {
    return run(test, options)["ate_m"].get<double>();
  }
};

}  // namespace
}  // namespace chasles::test
