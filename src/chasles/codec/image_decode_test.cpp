#include <random>

#include <chasles/codec/image_decode.hpp>
#include <chasles/recording/image_testing.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;

// Four bytes, the most significant one first.
std::string big_endian(std::uint32_t value) {
  std::string bytes;
  for (int shift = 24; shift >= 0; shift -= 8) bytes += static_cast<char>(value >> shift & 255);
  return bytes;
}

// A picture of any of OpenCV's types, smooth with noise.
cv::Mat noisy(int type, int width = 61, int height = 33) {
  std::mt19937 random(7);
  cv::Mat image(height, width, type);
  const std::size_t bytes = image.total() * image.elemSize();
  for (std::size_t i = 0; i < bytes; ++i) {
    image.data[i] = static_cast<std::uint8_t>(i / 3 + random() % 30);
  }
  return image;
}

void expect_as_opencv(const std::string& bytes, int most = 0) {
  EXPECT_LE(test::largest_difference(test::decoded(bytes), test::decoded_by_opencv(bytes)), most);
}

TEST(ImageDecode, GreyImagesOfAllKindsHaveThePixelsOfOpenCv) {
  for (const char* ending : {".png", ".jpg", ".pgm", ".bmp", ".tiff"}) {
    SCOPED_TRACE(ending);
    expect_as_opencv(test::encoded(noisy(CV_8UC1), ending));
    expect_as_opencv(test::encoded(noisy(CV_8UC1, 1, 1), ending));
  }
  expect_as_opencv(test::encoded(noisy(CV_8UC1), ".webp"), 1);  // it has colours alone
  for (const char* ending : {".png", ".pgm", ".tiff"}) {
    SCOPED_TRACE(ending);
    const std::string bytes = test::encoded(noisy(CV_16UC1), ending);
    EXPECT_TRUE(stated_image(bytes, "").deep);
    expect_as_opencv(bytes);
  }
}

TEST(ImageDecode, ColoursDifferFromOpenCvsByARoundingAtMost) {
  for (const int type : {CV_8UC3, CV_8UC4}) {
    for (const char* ending : {".png", ".bmp", ".tiff"}) {
      SCOPED_TRACE(ending);
      expect_as_opencv(test::encoded(noisy(type), ending), 1);
    }
  }
  for (const int type : {CV_16UC3, CV_16UC4}) expect_as_opencv(test::encoded(noisy(type)), 1);
  expect_as_opencv(test::encoded(noisy(CV_16UC3), ".tiff"), 1);
  expect_as_opencv(test::encoded(noisy(CV_8UC3), ".jpg"));
}

TEST(ImageDecode, LossyAndLosslessWebpIsRead) {
  const cv::Mat image = noisy(CV_8UC3);
  for (const int quality : {30, 90, 101}) {
    const auto bytes = test::opencv_encoded(".webp", image, {cv::IMWRITE_WEBP_QUALITY, quality});
    expect_as_opencv({bytes.begin(), bytes.end()}, 1);
    if (quality <= 100) continue;
    const GrayImage exact = test::decoded(test::encoded(image)),
                    same = test::decoded({bytes.begin(), bytes.end()});
    EXPECT_EQ(same.pixels, exact.pixels) << "as the PNG of the same picture";
  }
}

TEST(ImageDecode, ProgressiveJpegsAreRead) {
  const auto bytes =
      test::opencv_encoded(".jpg", noisy(CV_8UC3), {cv::IMWRITE_JPEG_PROGRESSIVE, 1});
  expect_as_opencv({bytes.begin(), bytes.end()});
}

// 12 bits of a sensor in 16, the lowest as many drivers write them.
TEST(ImageDecode, OfDeepImagesTheUsedBitsAreTaken) {
  cv::Mat deep(1, 4, CV_16UC1);
  const int values[] = {0, 255, 4095, 5000};
  for (int i = 0; i < 4; ++i) deep.at<std::uint16_t>(0, i) = static_cast<std::uint16_t>(values[i]);
  const std::vector<std::uint8_t> of_12{0, 15, 255, 255}, of_16{0, 0, 15, 19};
  for (const char* ending : {".png", ".tiff", ".pgm"}) {
    const std::string bytes = test::encoded(deep, ending);
    EXPECT_EQ(test::decoded(bytes, 12).pixels, of_12) << ending;
    EXPECT_EQ(test::decoded(bytes).pixels, of_16) << ending;
    EXPECT_EQ(largest_deep_value(bytes, {4, 1}, ""), 5000) << ending;
  }
  EXPECT_EQ(largest_deep_value(test::picture_bytes(1), {8, 6}, ""), std::nullopt);
}

TEST(ImageDecode, AHotPixelIsNotTheRange) {
  cv::Mat deep(50, 50, CV_16UC1, cv::Scalar(800));
  deep.at<std::uint16_t>(0, 7) = 1020;
  deep.at<std::uint16_t>(3, 7) = 65535;
  deep.at<std::uint16_t>(40, 7) = 65535;
  EXPECT_EQ(largest_deep_value(test::encoded(deep, ".png"), {50, 50}, ""), 1020);
}

TEST(ImageDecode, PgmHasItsOwnRangeTextAndComments) {
  const auto pixels = [](const std::string& bytes) { return test::decoded(bytes).pixels; };
  using Pixels = std::vector<std::uint8_t>;
  EXPECT_EQ(pixels("P2 # a comment\n2 2\n# another\n15\n0 5\n10 15"), (Pixels{0, 85, 170, 255}));
  EXPECT_EQ(pixels("P5 3 1 255\n" + std::string("\0\x80\xff", 3)), (Pixels{0, 128, 255}));
  EXPECT_EQ(pixels("P5\n2 1\n4095\n" + std::string("\x0f\xff\x01\x00", 4)), (Pixels{255, 16}));
  EXPECT_EQ(pixels("P5\n2 1\n4095\n" + std::string("\xff\xff\x00\x0f", 4)), (Pixels{255, 0}));
  EXPECT_EQ(pixels("P2 2 1 1000 1000 500"), (Pixels{255, 127}));
  for (const char* bytes :
       {"P5 3 1 255\nab", "P2 2 1 9 1", "P5 3 1", "P5 3 1 0\nabc", "P5 -1 1 255\n",
        "P5 3 1 70000\nabcabc", "P2 1 1 9 x", "P5 0 1 255\n"}) {
    expect_parts(input_error([&] { test::decoded(bytes); }), {"file", "the image is damaged"});
  }
}

TEST(ImageDecode, BmpMayBeginAtTheTopAndHaveFewColours) {
  std::string bmp = test::encoded(noisy(CV_8UC1, 8, 6), ".bmp");
  const GrayImage upwards = test::decoded(bmp);
  bmp.replace(22, 4, std::string("\xfa\xff\xff\xff", 4));  // -6 rows
  const GrayImage downwards = test::decoded(bmp);
  for (std::size_t i = 0; i < 48; ++i) {
    EXPECT_EQ(downwards.pixels[i], upwards.pixels[(5 - i / 8) * 8 + i % 8]);
  }
  // One bit a pixel: black and white.
  std::string bits("BM\0\0\0\0\0\0\0\0\x3e\0\0\0\x28\0\0\0\x0a\0\0\0\x01\0\0\0\x01\0\x01\0", 30);
  bits += std::string(24, '\0') + std::string("\0\0\0\0\xff\xff\xff\0\xa5\x80\0\0", 12);
  EXPECT_EQ(test::decoded(bits).pixels,
            (std::vector<std::uint8_t>{255, 0, 255, 0, 0, 255, 0, 255, 255, 0}));
  expect_as_opencv(bits);
  bits[30] = 1;  // packed
  expect_parts(input_error([&] { test::decoded(bits); }), {"compression 1", "convert the images"});
}

TEST(ImageDecode, TruncatedFilesOfAllKindsAreDamage) {
  for (const char* ending : {".png", ".jpg", ".pgm", ".bmp", ".tiff", ".webp"}) {
    const std::string bytes = test::encoded(noisy(CV_8UC1), ending);
    for (const std::size_t left : {bytes.size() - 12, bytes.size() / 2, std::size_t{60}}) {
      const std::string error = input_error([&] { test::decoded(bytes.substr(0, left)); });
      expect_parts(error, {"file: ", "the image is damaged, copy it again"});
    }
  }
}

TEST(ImageDecode, ATornJpegWithAnEndIsDamage) {
  const std::string bytes = test::encoded(noisy(CV_8UC1, 200, 200), ".jpg");
  const std::string torn = bytes.substr(0, bytes.size() / 2) + "\xff\xd9";
  expect_parts(input_error([&] { test::decoded(torn); }), {"the JPEG cannot be decoded"});
  // Zeros after the end, and bytes between segments, harm nothing.
  EXPECT_EQ(test::decoded(bytes + std::string(100, '\0')).pixels, test::decoded(bytes).pixels);
}

TEST(ImageDecode, KindsThatAreNotReadAreNamed) {
  expect_parts(input_error([&] { test::decoded(test::encoded(noisy(CV_32FC1), ".tiff")); }),
               {"1 channels of 32 bits", "8 or 16 bits", "convert the images"});
  expect_parts(input_error([&] { test::decoded("GIF89a"); }),
               {"is of no known kind, expected a PNG, JPEG, PGM, BMP, TIFF or WebP image"});
  expect_parts(input_error([&] { test::decoded(""); }), {"is empty"});
}

TEST(ImageDecode, NamesOfImagesEndInAnyLettersAndAreNotHidden) {
  for (const char* name :
       {"0.png", "0.PNG", "a.Jpg", "a.jpeg", "b.pgm", "b.BMP", "c.tif", "c.tiff", "d.webp"}) {
    EXPECT_TRUE(is_image_name(name)) << name;
  }
  for (const char* name : {"._0.png", ".png", "0.txt", "png", "times.csv", "0.png.part"}) {
    EXPECT_FALSE(is_image_name(name)) << name;
  }
}

TEST(ImageDecode, AnAbsurdSizeIsRejectedBeforeAnythingIsMade) {
  std::string png = test::picture_bytes(0);
  const ImageSize large{.width = 20000, .height = 20000};
  png.replace(16, 8, big_endian(20000) + big_endian(20000));
  expect_parts(input_error([&] { decode_image(png, large, "file"); }),
               {"file: states 20000 x 20000 pixels, expected at most 100000000"});
  png.replace(16, 4, big_endian(0xfffffff0));
  expect_parts(input_error([&] { stated_size(png, "file"); }), {"absurd size"});
  std::string jpeg = test::encoded(test::picture(0), ".jpg");
  const std::size_t frame = jpeg.find("\xff\xc0");
  ASSERT_NE(frame, std::string::npos);
  jpeg.replace(frame + 5, 4, "\x4e\x20\x4e\x20");
  EXPECT_EQ(stated_size(jpeg, "file"), large);
  expect_parts(input_error([&] { decode_image(jpeg, large, "file"); }), {"states 20000 x 20000"});
}

}  // namespace
}  // namespace chasles
