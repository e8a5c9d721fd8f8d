#include <filesystem>
#include <fstream>

#include <Eigen/Cholesky>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/calibrate/calibrate_testing.hpp>
#include <chasles/calibrate/recorded_views.hpp>
#include <chasles/calibrate/target_images.hpp>
#include <chasles/camera/camera_testing.hpp>
#include <chasles/codec/image_encode.hpp>
#include <chasles/target/target_testing.hpp>

namespace chasles::test {
namespace {

namespace fs = std::filesystem;

class TargetImagesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / fmt::format("chasles_target_{}", ::getpid());
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  void write(const fs::path& name, const GrayImage& image) const {
    fs::create_directories((folder_ / name).parent_path());
    std::ofstream(folder_ / name, std::ios::binary) << png_bytes(image);
  }

  fs::path folder_;
};

// From photographs alone to a camera whose errors are those of its covariance.
TEST_F(TargetImagesTest, ACameraIsCalibratedByRenderedPhotographs) {
  const Camera camera = euroc_camera();
  const Target target = april_board();
  const TargetRenderer renderer(target, camera);
  const std::vector<SE3> poses = board_poses({.cameras = {camera}, .instants = 24}, 3);
  for (std::size_t i = 0; i < poses.size(); ++i) {
    write(fmt::format("photo_{:02d}.png", i), renderer.render(poses[i], {.seed = i + 1}));
  }
  ASSERT_TRUE(is_target_images(folder_));
  const Recording recording = read_target_images(folder_);
  ASSERT_EQ(recording.cameras.size(), 1u);
  EXPECT_EQ(recording.cameras[0].width, camera.width);
  const RecordedViews one = recorded_views(recording, target);
  const RecordedViews two = recorded_views(recording, target, {.threads = 2});
  EXPECT_EQ(one.frames, poses.size());
  EXPECT_GT(one.seen[0], 20u);
  ASSERT_EQ(one.views.size(), two.views.size());
  for (std::size_t i = 0; i < one.views.size(); ++i) {
    EXPECT_EQ(one.views[i].ids, two.views[i].ids);
    EXPECT_EQ(one.views[i].pixels, two.views[i].pixels) << "any number of threads";
  }
  CamerasInput input{.corners = target.corners(),
                     .views = one.views,
                     .cameras = recording.cameras,
                     .lenses = {form_of(camera)},
                     .shape = printed_shape(target)};
  const CamerasCalibration found = calibrate_cameras(input);
  EXPECT_LT(found.pixel_sigma, 0.1);
  const Eigen::VectorXd errors = calibration_errors(found, {camera});
  const double nees = errors.dot(found.covariance.ldlt().solve(errors));
  EXPECT_LT(nees / static_cast<double>(errors.size()), 3) << errors.transpose();
  EXPECT_LT(std::abs(errors[0]), 0.5) << "fx";
}

TEST_F(TargetImagesTest, CamerasShareInstantsByNames) {
  const GrayImage grey{.width = 8, .height = 6, .pixels = std::vector<std::uint8_t>(48, 100)};
  for (const char* name : {"cam0/1000000000.png", "cam0/1050000000.png", "cam1/1050000000.png"}) {
    write(name, grey);
  }
  ASSERT_TRUE(is_target_images(folder_));
  const Recording recording = read_target_images(folder_);
  ASSERT_EQ(recording.images->size(), 2u);
  EXPECT_EQ(recording.images->time(1), Time(1050000000));
  EXPECT_FALSE(recording.images->has_image(0, 1));
  EXPECT_EQ(recording.images->read(1).images.size(), 2u);
  EXPECT_THROW(recorded_views({}, april_board()), InputError);
  std::ofstream(folder_ / "board.yaml")
      << "target_type: aprilgrid\ntagCols: 6\ntagRows: 6\ntagSize: 0.088\ntagSpacing: 0.3\n";
  EXPECT_TRUE(is_target_images(folder_));
  std::ofstream(folder_ / "calibration.yaml") << "cameras: []\n";
  EXPECT_FALSE(is_target_images(folder_)) << "a recording";
}

TEST(TimesOfNames, StampsInAnyUnitAreRead) {
  using Names = std::vector<std::string>;
  using Times = std::vector<Time>;
  const Time first(1403636584763556000), second(1403636584813556000);
  for (const Names& names : {Names{"1403636584763556000", "1403636584813556000"},
                             {"1403636584763556", "1403636584813556"},
                             {"left_1403636584.763556", "left_1403636584.813556"}}) {
    EXPECT_EQ(times_of_names(names), (Times{first, second})) << names[0];
  }
  const Times counted{Time(0), std::chrono::seconds(1)};
  for (const Names& names : {Names{"frame_0001", "frame_0002"},
                             {"frame.0001", "frame.0002"},
                             {"20240501123456", "20240501123457"},
                             {"a", "1403636584763556000"},
                             {"a1403636584763556000", "b1403636584813556000"}}) {
    EXPECT_EQ(times_of_names(names), counted) << names[0];
  }
  EXPECT_TRUE(times_of_names({}).empty());
}

TEST_F(TargetImagesTest, AnImageOfAnotherSizeIsReportedAndLeftOut) {
  write("a.png", {.width = 8, .height = 6, .pixels = std::vector<std::uint8_t>(48, 100)});
  write("b.png", {.width = 6, .height = 8, .pixels = std::vector<std::uint8_t>(48, 100)});
  const RecordedViews views = recorded_views(read_target_images(folder_), april_board());
  ASSERT_EQ(views.damaged.size(), 1u);
  EXPECT_NE(views.damaged[0].find("b.png"), std::string::npos);
}

}  // namespace
}  // namespace chasles::test
