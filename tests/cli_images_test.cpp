#include <sstream>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include <chasles/base/opencv_codecs_testing.hpp>

#include "cli_test.hpp"

// `chasles simulate --images`.
namespace chasles::test {
namespace {

// One to two seconds of small images.
const std::string kSmall =
    "--set walk_duration=6 --set image_width=160 --set image_height=120 --set focal_length=100 "
    "--set center_u=79.5 --set center_v=59.5 --set texel_size=0.05 --set frame_rate=4 ";

TEST(SimulateImages, WritesARecordingThatIsTheSameWithAnyNumberOfThreads) {
  const Scratch folder;
  for (const char* run : {"a --threads 1 ", "b --threads 3 "}) {
    const Outcome outcome = chasles(folder, std::string("simulate walk --images --json -o ") + run +
                                                "--set cameras=2 " + kSmall);
    ASSERT_EQ(outcome.code, 0) << outcome.err;
    const auto json = nlohmann::json::parse(outcome.out);
    EXPECT_EQ(json["frames"], 25);
    EXPECT_EQ(json["cameras"], 2);
    EXPECT_EQ(json["settings"]["walk_duration"], 6.0);
  }
  for (const char* file : {"mav0/cam0/data.csv", "mav0/cam1/data/5000000000.png",
                           "mav0/imu0/data.csv", "mav0/state_groundtruth_estimate0/data.csv"}) {
    const std::string bytes = slurp(folder / "a" / file);
    EXPECT_FALSE(bytes.empty()) << file;
    EXPECT_EQ(bytes, slurp(folder / "b" / file)) << file;
  }
}

TEST(SimulateImages, TakesTheCamerasOfARecording) {
  const Scratch folder;
  ASSERT_EQ(chasles(folder, "simulate walk --images --quiet -o a --set cameras=2 " + kSmall).code,
            0);
  const Outcome outcome = chasles(
      folder, "simulate hallway --images --cameras a -o b --set frame_rate=0.1 --set texel_size=1");
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  expect_part(outcome.out, "frames of one image");
  expect_part(slurp(folder / "b/mav0/cam0/sensor.yaml"), "resolution: [160, 120]");
  expect_error(chasles(folder, "simulate hallway --images --cameras b -o c --set cameras=2"), 1,
               "--cameras b: has 1 cameras; expected 2");
}

// A gyroscope with a wrong sign.
TEST(RunOfImages, TakesTheRecordingAsItIsOnlyWhereAsked) {
  const Scratch folder;
  ASSERT_EQ(chasles(folder,
                    "simulate hallway --images -o rec --quiet --set hall_length=8 --set sections=1 "
                    "--set rest_duration=1 --set frame_rate=10 --set focal_length=200 "
                    "--set image_width=320 --set image_height=240 --set center_u=159.5 "
                    "--set center_v=119.5")
                .code,
            0);
  const std::filesystem::path imu = folder / "rec/mav0/imu0/data.csv";
  std::istringstream rows(slurp(imu));
  std::string flipped;
  for (std::string line; std::getline(rows, line);) {
    if (line[0] != '#') {
      const std::size_t y = line.find(',', line.find(',') + 1) + 1;
      line = line[y] == '-' ? line.erase(y, 1) : line.insert(y, "-");
    }
    flipped += line + "\n";
  }
  spill(imu, flipped);
  const Outcome mended = chasles(folder, "run rec --json --quiet");
  ASSERT_EQ(mended.code, 0) << mended.err;
  const auto summary = nlohmann::json::parse(mended.out);
  expect_part(summary["remarks"].dump(), "the gyroscope's y has the wrong sign");
  EXPECT_LT(summary["ate_posyaw_m"].get<double>(), 0.05);
  const Outcome recorded = chasles(folder, "run rec --json --quiet --as-recorded");
  EXPECT_EQ(recorded.out.find("the gyroscope's y has the wrong sign, by"), std::string::npos);
  if (recorded.code != 0) return;  // it may find no start at all
  EXPECT_GT(nlohmann::json::parse(recorded.out)["ate_posyaw_m"].get<double>(), 0.1);
}

TEST(SimulateImages, RejectsWhatCannotBe) {
  const Scratch folder;
  std::filesystem::create_directories(folder / "mine");
  spill(folder / "mine/notes.txt", "of years");
  spill(folder / "file", "");
  expect_error(chasles(folder, "simulate street --images -o x"), 1, "--images and --cameras are");
  expect_error(chasles(folder, "simulate walk --images -o mine"), 1, "is not empty");
  expect_error(chasles(folder, "simulate walk --images -o file"), 1, "cannot be made");
  expect_error(chasles(folder, "simulate walk --images -o x --cameras none"), 2, "none");
  expect_error(
      chasles(folder, "simulate walk --images -o x --set distortion=fisheye"), 1,
      "distortion: found 'fisheye', expected one of none, radtan, equidistant, ds, eucm, omni");
  expect_error(chasles(folder, "simulate walk --images -o x --set exposure_time=0.5"), 1,
               "exposure_time = 0.5 s: expected at most");
  expect_error(chasles(folder, "simulate walk --images -o x --threads 0"), 1, "--threads");
  EXPECT_EQ(slurp(folder / "mine/notes.txt"), "of years");
}

// Black up to a column.
std::string mask_png(int width, int height, int first_white) {
  cv::Mat mask(height, width, CV_8UC1, cv::Scalar(0));
  mask.colRange(first_white, width).setTo(255);
  const std::vector<std::uint8_t> bytes = opencv_encoded(".png", mask);
  return {bytes.begin(), bytes.end()};
}

TEST(MaskedImages, AreTrackedOnlyWhereTheMaskIsNotBlack) {
  const Scratch folder;
  ASSERT_EQ(chasles(folder,
                    "simulate walk --images --quiet -o walk --set walk_duration=3 --set "
                    "rest_duration=1 --set image_width=320 --set image_height=240 --set "
                    "focal_length=200 --set center_u=159.5 --set center_v=119.5 --set "
                    "texel_size=0.03")
                .code,
            0);
  spill(folder / "half.png", mask_png(320, 240, 160));
  spill(folder / "none.png", mask_png(320, 240, 0));
  spill(folder / "small.png", mask_png(160, 120, 80));
  spill(folder / "text.png", "of years");
  const auto added = [&](const std::string& more) {
    const Outcome run = chasles(folder, "run walk --begin truth --json --quiet " + more);
    EXPECT_EQ(run.code, 0) << run.err;
    const auto json = nlohmann::json::parse(run.out, nullptr, false);
    return run.code == 0 ? json["frontend"]["added"].get<int>() : 0;
  };
  const int all = added("");
  EXPECT_GT(all, 100);
  EXPECT_EQ(added("--set frontend.mask=none.png"), all);
  const int half = added("--set frontend.mask=half.png");
  EXPECT_LT(half, 0.8 * all);
  EXPECT_GT(half, 0.2 * all);
  const std::string run = "run walk --quiet --begin truth --set frontend.mask=";
  expect_error(chasles(folder, run + "small.png"), 2,
               "small.png: is 160 x 120 pixels, expected 320 x 240");
  expect_error(chasles(folder, run + "text.png"), 2, "text.png: is of no known kind");
  expect_error(chasles(folder, run + "gone.png"), 2, "gone.png");
  expect_error(chasles(folder, run + "half.png,half.png"), 1,
               "names more files than there are cameras (1)");
}

}  // namespace
}  // namespace chasles::test
