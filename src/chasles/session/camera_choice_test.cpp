#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/all_cameras.hpp>
#include <chasles/session/camera_choice.hpp>

namespace chasles {
namespace {

using Numbers = std::vector<std::size_t>;

/// Camera c's image in frame i has one pixel of grey 10 i + c; camera 2 has one in frame 1 only.
class Four : public ImageSource {
 public:
  std::size_t size() const override { return 3; }
  Time time(std::size_t i) const override { return Time(100 * static_cast<int>(i)); }
  ImageFrame read(std::size_t i) const override {
    ImageFrame frame{.time = time(i), .images = {}};
    for (std::size_t c = 0; c < 4; ++c) {
      frame.images.push_back(
          has_image(i, c) ? GrayImage{1, 1, {static_cast<std::uint8_t>(10 * i + c)}} : GrayImage{});
    }
    return frame;
  }
  bool has_image(std::size_t i, std::size_t camera) const override { return camera != 2 || i == 1; }
};

Recording four_cameras() {
  Recording r;
  r.name = "four";
  for (int c = 0; c < 4; ++c) r.cameras.push_back({.width = c + 1, .cam_T_imu = {}});
  r.images = std::make_shared<Four>();
  r.frames.push_back(
      {.time = Time(0), .pixels = {{1, 0, {}, {0, 0}}, {1, 1, {}, {1, 0}}, {1, 3, {}, {3, 0}}}});
  return r;
}

void expect_rejected(const std::string& text, const std::string& part) {
  try {
    Recording r = four_cameras();
    choose_cameras(r, *camera_choice(text));
    ADD_FAILURE() << "expected an error for " << text;
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
  }
}

TEST(CameraChoice, IsNamesOrNumbers) {
  EXPECT_FALSE(camera_choice(""));
  EXPECT_EQ(camera_choice("mono"), Numbers{0});
  EXPECT_EQ(camera_choice("stereo"), (Numbers{0, 1}));
  EXPECT_EQ(camera_choice("3,0,2"), (Numbers{3, 0, 2}));
  EXPECT_EQ(cameras_to_read(camera_choice("3,0,2")), 4u);
  EXPECT_EQ(cameras_to_read(std::nullopt), kAllCameras);
}

TEST(CameraChoice, RejectsWhatIsNoChoice) {
  for (const char* text :
       {"quad", "0,", ",1", "0;1", "-1", "0, 1", "1.5", "99999999999999999999"}) {
    expect_rejected(text, "expected mono, stereo, or the numbers");
  }
  expect_rejected("0,2,0", "a camera twice");
  expect_rejected("0,1,2,3,4,5,6,7,8", "more than 8");
  expect_rejected("0,4", "no camera 4: four has 4 single cameras, expected at least 5");
}

TEST(CameraChoice, KeepsTheseCamerasInThisOrder) {
  Recording r = four_cameras();
  choose_cameras(r, {3, 0});
  ASSERT_EQ(r.cameras.size(), 2u);
  EXPECT_EQ(r.cameras[0].width, 4);
  EXPECT_EQ(r.camera_numbers, (Numbers{3, 0}));
  const ImageFrame frame = r.images->read(1);
  ASSERT_EQ(frame.images.size(), 2u);
  EXPECT_EQ(frame.images[0].pixels[0], 13);
  EXPECT_EQ(frame.images[1].pixels[0], 10);
  EXPECT_EQ(r.images->read_cameras(2, 1).images.size(), 1u);
  ASSERT_EQ(r.frames[0].pixels.size(), 2u);
  EXPECT_EQ(r.frames[0].pixels[0].camera, 0);
  EXPECT_EQ(r.frames[0].pixels[0].pixel.x(), 3);
}

// Also where the cameras that remain are the first.
TEST(CameraChoice, MatchesOfAFinderThatIsLeftOutAreTracksOfTheirOwn) {
  for (const auto& choice : {Numbers{0}, Numbers{0, 3}, Numbers{0, 1}}) {
    Recording r = four_cameras();
    r.frames[0].pixels = {{1, 0, {}, {0, 0}}, {1, 1, {}, {1, 0}}, {1, 3, {}, {3, 0}}};
    r.frames[0].pixels[0].match = true;
    r.frames[0].pixels[1].match = false;
    r.frames[0].pixels[2].match = true;
    choose_cameras(r, choice);
    const bool has_finder = choice.back() == 1;
    EXPECT_EQ(r.frames[0].pixels[0].match.has_value(), has_finder) << choice.back();
  }
}

TEST(CameraChoice, LeavesOutFramesWithoutTheirImages) {
  Recording r = four_cameras();
  choose_cameras(r, {2});
  ASSERT_EQ(r.images->size(), 1u);
  EXPECT_EQ(r.images->time(0), Time(100));
  EXPECT_EQ(r.images->read(0).images[0].pixels[0], 12);
}

TEST(CameraChoice, CountsInTheCalibrationWhereACameraHasNoImages) {
  Recording r = four_cameras();
  r.camera_numbers = {0, 1, 3, 4};  // camera 2 is calibrated, but has no images
  choose_cameras(r, {3});
  EXPECT_EQ(r.cameras[0].width, 3);
  Recording again = four_cameras();
  again.camera_numbers = {0, 1, 3, 4};
  try {
    choose_cameras(again, {2});
    ADD_FAILURE();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what())
                  .find("camera 2 of four has no images, expected some of 0, "
                        "1, 3, 4"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace chasles
