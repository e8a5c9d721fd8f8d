#include <cmath>

#include <opencv2/imgproc.hpp>

#include <chasles/bags/bag_testing.hpp>
#include <chasles/bags/bayer.hpp>
#include <chasles/bags/ros_image.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;
using test::kStamp;

const ImageSize kSize{.width = 8, .height = 6};

GrayImage grey(const cv::Mat& image, const std::string& encoding, int bits = 8, std::size_t gap = 0,
               bool big_endian = false) {
  const std::string bytes = test::image_message(kStamp, image, encoding, gap, big_endian);
  return grey_image(ros_image({.bytes = bytes}), kSize, bits, "image");
}

TEST(RosImage, GreyIsTakenAsItIs) {
  for (const std::size_t gap : {0u, 5u}) {
    for (const char* encoding : {"mono8", "8UC1"}) {
      const GrayImage image = grey(test::picture(40), encoding, 8, gap);
      ASSERT_EQ(image.pixels.size(), 48u);
      EXPECT_EQ(image.pixels[47], 47);
    }
  }
}

TEST(RosImage, ColoursOfEveryOrderBecomeGrey) {
  // 0.299 * 200 + 0.587 * 100 + 0.114 * 10 = 119.64, rounded down as in image files
  const cv::Scalar bgr(10, 100, 200), rgb(200, 100, 10);
  for (const char* name : {"bgr8", "8UC3", "bgra8", "8UC4"}) {
    const int type = std::string(name).find_first_of("a4") < 4 ? CV_8UC4 : CV_8UC3;
    EXPECT_EQ(grey(cv::Mat(6, 8, type, bgr), name).pixels[5], 119) << name;
  }
  EXPECT_EQ(grey(cv::Mat(6, 8, CV_8UC3, rgb), "rgb8").pixels[5], 119);
  EXPECT_EQ(grey(cv::Mat(6, 8, CV_8UC4, rgb), "rgba8").pixels[5], 119);
  EXPECT_EQ(grey(cv::Mat(6, 8, CV_16UC3, rgb * 16), "rgb16", 12).pixels[5], 119);
}

TEST(RosImage, OfYuvTheGreyIsTaken) {
  const cv::Mat uyvy(6, 8, CV_8UC2, cv::Scalar(128, 77)), yuyv(6, 8, CV_8UC2, cv::Scalar(77, 128));
  for (const char* name : {"yuv422", "uyvy"}) EXPECT_EQ(grey(uyvy, name).pixels[9], 77);
  for (const char* name : {"yuv422_yuy2", "yuyv"}) EXPECT_EQ(grey(yuyv, name).pixels[9], 77);
  // Below the rows of grey lie half as many of colours.
  const cv::Mat planes(9, 8, CV_8UC1, cv::Scalar(55));
  for (const char* name : {"nv12", "nv21"}) {
    const std::string bytes = test::image_message(kStamp, planes, name);
    RosImage image = ros_image({.bytes = bytes});
    image.height = 6;
    EXPECT_EQ(grey_image(image, kSize, 8, "image").pixels[47], 55);
    image.height = 7;
    expect_parts(input_error([&] { grey_image(image, {8, 7}, 8, "image"); }), {"holds 72 bytes"});
  }
}

// A camera of 12 bits.
TEST(RosImage, OfSixteenBitsThoseInUseAreTaken) {
  cv::Mat image(6, 8, CV_16UC1, cv::Scalar(1000));
  image.at<std::uint16_t>(3, 2) = 2600;
  for (const bool big : {false, true}) {
    cv::Mat sent = image.clone();
    if (big) {
      for (int i = 0; i < 48; ++i) {
        auto& value = sent.at<std::uint16_t>(i);
        value = static_cast<std::uint16_t>(value << 8 | value >> 8);
      }
    }
    const std::string bytes = test::image_message(kStamp, sent, "mono16", 0, big);
    const RosImage read = ros_image({.bytes = bytes});
    EXPECT_EQ(largest_deep_value(read, kSize, "image"), 2600);
    const GrayImage made = grey_image(read, kSize, 12, "image");
    EXPECT_EQ(made.pixels[0], 1000 / 16);
    EXPECT_EQ(made.pixels[3 * 8 + 2], 2600 / 16);
  }
  const std::string shallow = test::image_message(kStamp, test::picture(1), "mono8");
  EXPECT_EQ(largest_deep_value(ros_image({.bytes = shallow}), kSize, "image"), std::nullopt);
}

// A row of no bytes would lie in any data, as often as a height of 32 bits says.
TEST(RosImage, WithoutPixelsIsRejectedAtOnce) {
  const std::string bytes = test::image_message(kStamp, test::picture(1), "mono16");
  RosImage image = ros_image({.bytes = bytes});
  image.width = 0;
  image.step = 0;
  image.height = 0x7fffffff;
  expect_parts(input_error([&] {
                 largest_deep_value(image, {0, 0x7fffffff}, "image");
               }),
               {"image: has no pixels"});
  expect_parts(input_error([&] { largest_deep_value(image, kSize, "image"); }),
               {"is 0 x 2147483647 pixels, expected 8 x 6"});
}

// Another demosaicing of the same kind: OpenCV's, whose names of patterns begin at the second row
// and column. It rounds the colours first, and has edges of its own.
TEST(RosImage, AMosaicBecomesTheGreyOfItsColours) {
  cv::Mat mosaic(40, 60, CV_8UC1);
  cv::theRNG().state = 5;
  cv::randu(mosaic, 0, 256);
  const std::vector<std::uint16_t> values(mosaic.begin<std::uint8_t>(), mosaic.end<std::uint8_t>());
  const std::array codes{cv::COLOR_BayerBG2GRAY, cv::COLOR_BayerGB2GRAY, cv::COLOR_BayerGR2GRAY,
                         cv::COLOR_BayerRG2GRAY};
  for (int red = 0; red < 4; ++red) {
    const auto made = grey_of_mosaic(values, 60, 40, red);
    cv::Mat expected;
    cv::cvtColor(mosaic, expected, codes[static_cast<std::size_t>(red)]);
    int worst = 0;
    for (int v = 1; v < 39; ++v) {
      for (int u = 1; u < 59; ++u) {
        const int here = made[static_cast<std::size_t>(v * 60 + u)];
        worst = std::max(worst, std::abs(here - expected.at<std::uint8_t>(v, u)));
      }
    }
    EXPECT_LE(worst, 1) << "red at " << red;
  }
}

TEST(RosImage, AMosaicOfOneColourIsOfThatGreyUpToTheEdges) {
  const std::array names{"bayer_rggb8", "bayer_grbg8", "bayer_gbrg8", "bayer_bggr8"};
  for (int red = 0; red < 4; ++red) {
    cv::Mat mosaic(6, 8, CV_8UC1);
    for (int v = 0; v < 6; ++v) {
      for (int u = 0; u < 8; ++u) {
        const int place = 2 * (v % 2) + u % 2;
        mosaic.at<std::uint8_t>(v, u) = place == red ? 200 : place == 3 - red ? 10 : 100;
      }
    }
    const GrayImage made = grey(mosaic, names[static_cast<std::size_t>(red)]);
    for (const std::uint8_t pixel : made.pixels) EXPECT_EQ(pixel, 119);
  }
}

TEST(RosImage, WhatIsNoImageOfTheCameraIsRejected) {
  expect_parts(input_error([&] { grey(test::picture(1), "32FC1"); }),
               {"'32FC1'", "expected one of mono8", "bayer_rggb8"});
  expect_parts(input_error([&] { grey(test::picture(1, 9, 6), "mono8"); }),
               {"is 9 x 6 pixels, expected 8 x 6"});
  expect_parts(input_error([&] { grey(test::picture(1), "bgr8"); }),
               {"holds 48 bytes in rows of 8"});
}

}  // namespace
}  // namespace chasles
