#include <chasles/data/image_testing.hpp>
#include <chasles/data/masks.hpp>

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

TEST(Masks, WhatIsNoMaskOfTheCameraIsRefused) {
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

}  // namespace
}  // namespace chasles
