#include <chrono>
#include <csignal>
#include <filesystem>
#include <string>
#include <thread>
#include <vector>

#include <fmt/format.h>

#include <chasles/calibrate/calibrate_testing.hpp>
#include <chasles/camera/camera_testing.hpp>
#include <chasles/codec/image_encode.hpp>
#include <chasles/target/target_testing.hpp>

#include "cli_process.hpp"

// `chasles calibrate cameras --live`.
namespace chasles::test {
namespace {

namespace fs = std::filesystem;

constexpr const char* kBoard =
    "target_type: aprilgrid\ntagCols: 6\ntagRows: 6\ntagSize: 0.088\ntagSpacing: 0.3\n";

std::vector<std::string> rendered(std::size_t count) {
  const Camera camera = euroc_camera();
  const TargetRenderer renderer(april_board(), camera);
  std::vector<std::string> images;
  for (const SE3& pose : board_poses({.cameras = {camera}, .instants = count}, 3)) {
    images.push_back(png_bytes(renderer.render(pose, {.seed = images.size() + 1})));
  }
  return images;
}

std::string image_name(std::size_t i) {
  return fmt::format("frames/{}.png", 1'400'000'000'000'000'000 + 1'000'000'000 * i);
}

// A recorder that writes 20 images a second, which are found, named as missing, and calibrated.
TEST(CalibrateLive, SaysWhatIsMissingAndEndsAsAPlainRun) {
  const Scratch folder;
  const std::vector<std::string> images = rendered(44);
  spill(folder / "board.yaml", kBoard);
  Process live(folder, {"calibrate", "cameras", (folder / "frames").string(), "--target",
                        (folder / "board.yaml").string(), "--live", "--lens", "radtan", "-o",
                        (folder / "out").string()});
  ASSERT_TRUE(live.shows("there are no images yet")) << live.output();
  fs::create_directories(folder / "frames");
  spill(folder / image_name(0), images[0]);
  ASSERT_TRUE(live.shows("1 views, 1 independent")) << live.output();
  for (std::size_t i = 1; i < images.size(); ++i) {
    spill(folder / image_name(i), images[i].substr(0, images[i].size() / 2));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    spill(folder / image_name(i), images[i]);
  }
  EXPECT_TRUE(live.shows("enough: press Ctrl-C")) << live.output();
  EXPECT_TRUE(live.shows("no new image in")) << live.output();
  EXPECT_EQ(live.code_after(SIGINT), 0) << live.output();
  const std::string output = live.output();
  for (const char* part : {"parts of its image: show the target there, first at the",
                           "of 144 corners", "fx 45", "cam0: radtan, 44 views"}) {
    expect_part(output, part);
  }
  const Outcome plain =
      chasles(folder, "calibrate cameras frames --target board.yaml --lens radtan -o plain");
  ASSERT_EQ(plain.code, 0) << plain.err;
  EXPECT_TRUE(output.ends_with(plain.out)) << output;
  for (const char* file : {"cameras.json", "corners.csv", "calibration.yaml", "page.html"}) {
    EXPECT_EQ(slurp(folder / "out" / file), slurp(folder / "plain" / file)) << file;
  }
}

TEST(CalibrateLive, WhatCannotBeFollowedIsRejected) {
  const Scratch folder;
  spill(folder / "board.yaml", kBoard);
  spill(folder / "rec.bag", "#ROSBAG V2.0\n");
  const Outcome bag = chasles(folder, "calibrate cameras rec.bag --target board.yaml --live");
  EXPECT_EQ(bag.code, 1);
  expect_part(bag.err,
              "rec.bag is a file, expected a folder to which another program writes images");
  const Outcome two = chasles(folder, "calibrate cameras a b --target board.yaml --live");
  EXPECT_EQ(two.code, 1);
  expect_part(two.err, "--live: found 2 recordings, expected one folder");
}

// Nothing was recorded until Ctrl-C.
TEST(CalibrateLive, AnEmptyFolderIsAnError) {
  const Scratch folder;
  spill(folder / "board.yaml", kBoard);
  fs::create_directories(folder / "frames");
  Process live(folder, {"calibrate", "cameras", (folder / "frames").string(), "--target",
                        (folder / "board.yaml").string(), "--live"});
  ASSERT_TRUE(live.shows("there are no images yet"));
  EXPECT_EQ(live.code_after(SIGINT), 2);
  expect_part(live.output(), "frames: ");
}

}  // namespace
}  // namespace chasles::test
