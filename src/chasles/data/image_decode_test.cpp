#include <chasles/data/image_decode.hpp>
#include <chasles/data/image_testing.hpp>

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

TEST(ImageDecode, AnAbsurdSizeIsRefusedBeforeAnythingIsMade) {
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
