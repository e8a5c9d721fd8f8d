#include <chasles/codec/image_encode.hpp>
#include <chasles/recording/testing.hpp>
#include <chasles/run_folder/shown_images.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using test::expect_parts;
using test::input_error;

ImageFeature feature(LandmarkId id, int camera, Outcome outcome) {
  ImageFeature f{.seen = {.observation = {.landmark = id, .camera = camera, .pixel = {3.25, 4.5}},
                          .outcome = outcome},
                 .age = 7};
  if (outcome == Outcome::kWaiting) return f;
  f.before = Eigen::Vector2d(1.5, 2.75);
  f.seen.expected = ExpectedPixel{.pixel = {3.5, 4.25}, .covariance = Eigen::Matrix2d::Zero()};
  f.seen.expected->covariance << 0.5, -0.125, -0.125, 0.25;
  return f;
}

// Two cameras; the second has no picture of the second frame.
std::vector<ShownImage> example_images() {
  const std::string picture =
      jpeg_bytes({.width = 8, .height = 6, .pixels = std::vector<std::uint8_t>(48, 90)}, 8);
  std::vector<ShownImage> images;
  for (const Time time : {Time(1'000'000'007), Time(2'000'000'000)}) {
    for (const int camera : {0, 1}) {
      const bool shown = camera == 0 || images.size() < 2;
      images.push_back({.time = time,
                        .camera = camera,
                        .width = 8,
                        .height = 6,
                        .jpeg = shown ? picture : "",
                        .features = {}});
    }
  }
  images[0].features = {feature(5, 0, Outcome::kUsed), feature(9, 0, Outcome::kWaiting)};
  images[1].features = {feature(5, 1, Outcome::kRejected)};
  images[3].features = {feature(11, 1, Outcome::kInitialised)};
  return images;
}

TEST(ShownImages, AreReadAgainAsTheyWereWritten) {
  const auto folder = test::scratch();
  write_shown_images(example_images(), folder);
  const auto images = example_images(), again = read_shown_images(folder);
  ASSERT_EQ(again.size(), images.size());
  for (std::size_t i = 0; i < images.size(); ++i) {
    EXPECT_EQ(again[i].time, images[i].time);
    EXPECT_EQ(again[i].camera, images[i].camera);
    EXPECT_EQ(again[i].width, 8);
    EXPECT_EQ(again[i].height, 6);
    EXPECT_EQ(again[i].jpeg, images[i].jpeg);
    ASSERT_EQ(again[i].features.size(), images[i].features.size()) << i;
    for (std::size_t k = 0; k < images[i].features.size(); ++k) {
      const ImageFeature &a = again[i].features[k], &b = images[i].features[k];
      EXPECT_EQ(a.seen.observation.landmark, b.seen.observation.landmark);
      EXPECT_EQ(a.seen.observation.camera, b.seen.observation.camera);
      EXPECT_EQ(a.seen.observation.pixel, b.seen.observation.pixel);
      EXPECT_EQ(a.seen.outcome, b.seen.outcome);
      EXPECT_EQ(a.age, b.age);
      EXPECT_EQ(a.before, b.before);
      ASSERT_EQ(a.seen.expected.has_value(), b.seen.expected.has_value());
      if (!b.seen.expected) continue;
      EXPECT_EQ(a.seen.expected->pixel, b.seen.expected->pixel);
      EXPECT_EQ(a.seen.expected->covariance, b.seen.expected->covariance);
    }
  }
}

// Replaces a text in a file of the folder and returns the error message.
std::string error(const std::string& file, const std::string& what, const std::string& by) {
  const auto folder = test::scratch();
  write_shown_images(example_images(), folder);
  std::string text = test::slurp(folder / file);
  const auto place = text.find(what);
  EXPECT_NE(place, std::string::npos) << what;
  test::spill(folder / file, text.replace(place, what.size(), by));
  return input_error([&] { read_shown_images(folder); });
}

TEST(ShownImages, WhatIsWrongIsReportedWithItsPlace) {
  expect_parts(error("images.csv", "images/cam0_1000000007.jpg", "../../secret.jpg"),
               {"images.csv:2", "image", "expected images/cam0_1000000007.jpg"});
  expect_parts(error("images.csv", "2000000000,0", "1000000007,0"), {"images.csv:4", "rise"});
  expect_parts(error("images.csv", ",8,6,", ",-8,6,"), {"images.csv:2", "width", "-8"});
  expect_parts(error("images.csv", ",8,6,", ",7,6,"), {"cam0_1000000007.jpg", "wider", "7 px"});
  expect_parts(error("images/cam0_1000000007.jpg", "\xff\xd8", "no"), {"cam0_1000000007.jpg"});
  expect_parts(error("features.csv", "used", "lost"), {"features.csv:2", "outcome", "'lost'"});
  expect_parts(error("features.csv", "1000000007,1,", "1000000009,1,"),
               {"features.csv:4", "order"});
  expect_parts(error("features.csv", "3.25", "nan"), {"features.csv:2", "'u'"});
  expect_parts(error("features.csv", ",7,", ",-7,"), {"features.csv:2", "age"});
}

TEST(ShownImages, AFileThatIsMissingIsReported) {
  const auto folder = test::scratch();
  write_shown_images(example_images(), folder);
  fs::remove(folder / "images/cam1_1000000007.jpg");
  expect_parts(input_error([&] { read_shown_images(folder); }), {"cam1_1000000007.jpg"});
  write_shown_images(example_images(), folder);
  fs::remove(folder / "features.csv");
  expect_parts(input_error([&] { read_shown_images(folder); }), {"features.csv"});
}

}  // namespace
}  // namespace chasles
