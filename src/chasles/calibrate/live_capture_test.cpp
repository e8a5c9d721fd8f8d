#include <filesystem>
#include <fstream>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chasles/calibrate/calibrate_testing.hpp>
#include <chasles/calibrate/live_capture.hpp>
#include <chasles/calibrate/recorded_views.hpp>
#include <chasles/calibrate/target_images.hpp>
#include <chasles/camera/camera_testing.hpp>
#include <chasles/codec/image_encode.hpp>
#include <chasles/target/target_testing.hpp>

namespace chasles::test {
namespace {

namespace fs = std::filesystem;

class Growing : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / fmt::format("chasles_growing_{}", ::getpid());
    fs::remove_all(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const fs::path& name, const std::string& bytes) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
  }

  // The name of the shot that is taken after two polls.
  std::string taken(GrowingImages& images) const {
    images.poll();
    images.poll();
    const auto shot = images.take();
    return shot ? shot->name : "";
  }

  fs::path folder_;
};

TEST_F(Growing, TheNewestImageComesFirst) {
  GrowingImages images(folder_);
  EXPECT_EQ(taken(images), "") << "no folder yet";
  for (const char* name : {"8.png", "9.png", "10.png"}) write(name, "whole");
  EXPECT_EQ(taken(images), "10");
  EXPECT_EQ(taken(images), "9");
  write("11.png", "whole");
  EXPECT_EQ(taken(images), "11");
  EXPECT_EQ(images.waiting(), 1u);
  EXPECT_EQ(taken(images), "8");
  EXPECT_EQ(taken(images), "");
  EXPECT_EQ(images.names().size(), 4u);
  write("notes.txt", "no image");
  EXPECT_EQ(taken(images), "");
}

TEST_F(Growing, AFileThatGrowsIsNotTaken) {
  GrowingImages images(folder_);
  write("cam0/1.png", "");
  images.poll();
  images.poll();
  EXPECT_FALSE(images.take()) << "empty";
  write("cam0/1.png", "half");
  images.poll();
  EXPECT_FALSE(images.take()) << "it has grown";
  images.poll();
  const auto shot = images.take();
  ASSERT_TRUE(shot);
  images.put_back(*shot);
  EXPECT_EQ(taken(images), "") << "it is as it was";
  write("cam0/1.png", "half and half");
  EXPECT_EQ(taken(images), "1");
}

TEST_F(Growing, AShotHasTheImagesOfAllCameras) {
  GrowingImages images(folder_);
  for (const char* name :
       {"mav0/cam0/data/1.png", "mav0/cam1/data/1.png", "mav0/cam0/data/2.png"}) {
    write(name, "whole");
  }
  EXPECT_EQ(taken(images), "1");
  EXPECT_EQ(images.cameras(), 2u);
  EXPECT_EQ(taken(images), "") << "cam1 may write its image yet";
  for (const char* name : {"mav0/cam0/data/3.png", "mav0/cam1/data/3.png"}) write(name, "whole");
  EXPECT_EQ(taken(images), "3");
  images.poll();
  const auto alone = images.take();
  ASSERT_TRUE(alone) << "cam1 has lost it";
  EXPECT_EQ(alone->name, "2");
  EXPECT_EQ(alone->files[1], "");
}

// A recorder that writes while the images are searched.
TEST_F(Growing, WhatWasSearchedIsWhatIsFoundAtTheEnd) {
  const Camera camera = euroc_camera();
  const Target target = april_board();
  const TargetRenderer renderer(target, camera);
  const std::vector<SE3> poses = board_poses({.cameras = {camera}, .instants = 10}, 3);
  LiveCapture capture(folder_, target, {});
  capture.poll();
  EXPECT_FALSE(capture.search());
  EXPECT_EQ(capture.missing(), std::vector<std::string>{"there are no images yet"});
  std::string half;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const std::string bytes = png_bytes(renderer.render(poses[i], {.seed = i + 1}));
    const std::string name = fmt::format("{}.png", 1403636584763556000 + 50'000'000 * i);
    half = bytes.substr(0, bytes.size() / 2);
    write(name, i == 4 ? half : bytes);
    for (int tries = 0; tries < 2; ++tries) capture.poll();
    capture.search();
    if (i == 4) write(name, bytes);
  }
  for (int tries = 0; tries < 2; ++tries) capture.poll();
  while (capture.search()) continue;
  EXPECT_EQ(capture.skipped(), 0u);
  EXPECT_NE(capture.seen().find("of 144 corners"), std::string::npos) << capture.seen();
  EXPECT_NE(capture.found().find("10 views"), std::string::npos) << capture.found();
  EXPECT_FALSE(capture.missing().empty());

  const Recording recording = read_target_recording(folder_);
  const RecordedViews plain = recorded_views(recording, target);
  std::size_t asked = 0, known = 0;
  const RecordedViews again =
      recorded_views(recording, target, {.known = [&](const fs::path& file) {
                       const TargetDetection* found = capture.known(file);
                       ++asked;
                       known += found ? 1 : 0;
                       return found;
                     }});
  EXPECT_EQ(asked, poses.size());
  EXPECT_EQ(known, poses.size());
  ASSERT_EQ(again.views.size(), plain.views.size());
  for (std::size_t i = 0; i < plain.views.size(); ++i) {
    EXPECT_EQ(again.views[i].time, plain.views[i].time);
    EXPECT_EQ(again.views[i].ids, plain.views[i].ids);
    EXPECT_EQ(again.views[i].pixels, plain.views[i].pixels);
  }
  EXPECT_EQ(again.lacks, plain.lacks);
  const fs::path first = target_image_file(*recording.images, 0, 0);
  std::ofstream(first, std::ios::app) << "more";
  EXPECT_EQ(capture.known(first), nullptr) << "it is another image now";
}

}  // namespace
}  // namespace chasles::test
