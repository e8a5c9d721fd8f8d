#include <chasles/recording/image_testing.hpp>
#include <chasles/recording/masks.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;

Camera small() {
  Camera camera;
  camera.width = 8;
  camera.height = 6;
  return camera;
}

TEST(Masks, AreReadInTheOrderOfTheCameras) {
  const auto folder = test::scratch();
  const std::string a = (folder / "a.png").string(), b = (folder / "b.jpg").string();
  test::spill(a, test::picture_bytes(0));
  test::spill(b, test::encoded(test::picture(200), ".jpg"));
  const std::vector<Camera> two{small(), small()};
  EXPECT_TRUE(read_masks("", two).empty());
  EXPECT_TRUE(read_masks(" ", two).empty());
  const auto both = read_masks(a + ", " + b, two);
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(both[0].pixels[0], 0);
  EXPECT_EQ(both[0].pixels[3], 3);
  EXPECT_NEAR(both[1].pixels[0], 200, 8);
  const auto first = read_masks(a, two), second = read_masks("," + a, two);
  EXPECT_FALSE(first[0].empty());
  EXPECT_TRUE(first[1].empty());
  EXPECT_TRUE(second[0].empty());
  EXPECT_FALSE(second[1].empty());
}

TEST(Masks, WhatIsNoMaskOfTheCameraIsRejected) {
  const auto folder = test::scratch();
  const std::string large = (folder / "large.png").string(), text = (folder / "text").string();
  test::spill(large, test::encoded(test::picture(0, 9, 6)));
  test::spill(text, "of years");
  expect_parts(input_error([&] { read_masks(large, {small()}); }),
               {"large.png: is 9 x 6 pixels, expected 8 x 6 as in the calibration"});
  expect_parts(input_error([&] { read_masks(text, {small()}); }), {"text", "PNG, JPEG, PGM"});
  expect_parts(input_error([&] { read_masks("none.png", {small()}); }), {"none.png"});
  try {
    read_masks(",,x.png", {small(), small()});
    FAIL();
  } catch (const UsageError& error) {
    expect_parts(error.what(), {"more files than there are cameras (2)"});
  }
}

cv::Mat filled(int shade) { return {6, 8, CV_8UC1, cv::Scalar(shade)}; }

TEST(Masks, OneThatCoversTheWholeImageIsRejected) {
  const auto folder = test::scratch();
  const std::string black = (folder / "black.png").string();
  test::spill(black, test::encoded(filled(0)));
  expect_parts(input_error([&] { read_masks(black, {small()}); }),
               {"black.png", "all pixels of this mask are black", "inverted"});
}

TEST(Masks, OneThatDoesNothingIsSaid) {
  const auto folder = test::scratch();
  const auto file = [&](const char* name, const cv::Mat& image) {
    const std::string path = (folder / name).string();
    test::spill(path, test::encoded(image));
    return path;
  };
  cv::Mat half = filled(255), nearly = filled(0);
  half.rowRange(0, 2).setTo(0);
  nearly.at<std::uint8_t>(0, 0) = 255;
  const std::string white = file("white.png", filled(255)), good = file("good.png", half),
                    most = file("most.png", nearly),
                    clear = file("clear.png", cv::Mat(6, 8, CV_8UC4, cv::Scalar(255, 255, 255, 0)));
  EXPECT_DOUBLE_EQ(covered_share(read_masks(good, {small()})[0]), 1 / 3.0);
  EXPECT_EQ(covered_share({}), 0);
  const auto said = mask_remarks(white + "," + good, {small(), small()});
  ASSERT_EQ(said.size(), 1u);
  expect_parts(said[0], {"white.png covers nothing of the image of cam0", "no pixel is black"});
  EXPECT_EQ(said[0].find("transparency"), std::string::npos);
  expect_parts(mask_remarks(clear, {small()}).at(0),
               {"clear.png covers nothing", "its transparency does not count"});
  expect_parts(mask_remarks("," + most, {small(), small()}).at(0),
               {"most.png covers 97.9 % of the image of cam1"});
  EXPECT_TRUE(mask_remarks("", {small()}).empty());
}

// A recording may have masks by itself.
TEST(Masks, OfASettingTakeThePlaceOfTheRecordings) {
  const std::string file = (test::scratch() / "mask.png").string();
  test::spill(file, test::picture_bytes(0));
  Recording recording;
  recording.cameras = {small()};
  recording.masks = {read_mask(file, MaskKind::kWhiteHides, small())};
  EXPECT_EQ(masks_of(" ", recording)[0].pixels[0], 255);
  EXPECT_EQ(masks_of(" ", recording)[0].pixels[3], 0);
  EXPECT_EQ(masks_of(file, recording)[0].pixels[3], 3);
}

}  // namespace
}  // namespace chasles
