#include <algorithm>

#include <chasles/codec/image_encode.hpp>
#include <chasles/codec/png_rows.hpp>
#include <chasles/codec/png_testing.hpp>
#include <chasles/recording/image_testing.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;
using test::PngKind;
using test::random_png;

std::vector<PngKind> all_png_kinds() {
  std::vector<PngKind> kinds;
  for (const auto& [colour, depths] : std::vector<std::pair<int, std::vector<int>>>{
           {0, {1, 2, 4, 8, 16}}, {2, {8, 16}}, {3, {1, 2, 4, 8}}, {4, {8, 16}}, {6, {8, 16}}}) {
    for (const int depth : depths) {
      for (const bool interlaced : {false, true}) {
        kinds.push_back({.width = 37,
                         .height = 29,
                         .depth = depth,
                         .colour = colour,
                         .interlaced = interlaced});
      }
    }
  }
  return kinds;
}

TEST(PngDecode, EveryKindHasThePixelsOfLibpng) {
  for (const PngKind& kind : all_png_kinds()) {
    SCOPED_TRACE(
        fmt::format("colour {}, {} bits, interlaced {}", kind.colour, kind.depth, kind.interlaced));
    for (unsigned seed = 0; seed < 5; ++seed) {
      const std::string png = random_png(kind, seed);
      const GrayImage ours = test::decoded(png), theirs = test::decoded_by_opencv(png);
      // Of 16 bits libpng takes the high bytes before it weighs the colours.
      const int most = kind.depth == 16 && (kind.colour & 2) != 0 ? 1 : 0;
      EXPECT_LE(test::largest_difference(ours, theirs), most);
    }
  }
}

TEST(PngDecode, EveryFilterHasThePixelsOfLibpngAtAnySize) {
  for (int filter = -1; filter < 5; ++filter) {
    for (const std::uint32_t width : {1u, 2u, 7u, 8u, 9u, 64u, 100u}) {
      for (const std::uint32_t height : {1u, 7u, 8u, 9u, 17u}) {
        for (const int colour : {0, 2, 6}) {
          const std::string png = random_png(
              {.width = width, .height = height, .colour = colour, .filter = filter}, width);
          EXPECT_EQ(test::decoded(png).pixels, test::decoded_by_opencv(png).pixels)
              << filter << ": " << width << " x " << height << ", colour " << colour;
        }
      }
    }
  }
}

TEST(PngDecode, SmallInterlacedImagesHaveEmptyPasses) {
  for (std::uint32_t width = 1; width < 10; ++width) {
    for (std::uint32_t height = 1; height < 10; ++height) {
      const std::string png =
          random_png({.width = width, .height = height, .interlaced = true}, height);
      EXPECT_EQ(test::decoded(png).pixels, test::decoded_by_opencv(png).pixels)
          << width << " x " << height;
    }
  }
}

// A PNG with other parts for its pixels.
std::string png_of_rows(const std::string& deflated) {
  const std::string png = random_png({.width = 8, .height = 6}, 1);
  return png.substr(0, 33) + test::png_chunk("IDAT", deflated) + test::png_chunk("IEND", "");
}

TEST(PngDecode, PixelsThatAreMissingOrTooManyAreDamage) {
  const std::string rows(6 * 9, '\0');
  EXPECT_EQ(test::decoded(png_of_rows(test::zlib_bytes(rows))).pixels[0], 0);
  const auto error = [](const std::string& deflated) {
    return input_error([&] { test::decoded(png_of_rows(deflated)); });
  };
  expect_parts(error(test::zlib_bytes(rows.substr(1))), {"fewer pixels than it states"});
  expect_parts(error(test::zlib_bytes(rows + '\0')), {"more pixels than it states"});
  expect_parts(error(""), {"check sum"});
  std::string sum = test::zlib_bytes(rows);
  sum.back() = static_cast<char>(sum.back() ^ 1);
  expect_parts(error(sum), {"compressed pixels or their check sum are wrong"});
  std::string filter = rows;
  filter[9] = 5;
  expect_parts(error(test::zlib_bytes(filter)), {"a filter that PNG does not have"});
}

TEST(PngDecode, ABombIsRejectedBeforeMemoryIsTaken) {
  std::string png = random_png({.width = 10000, .height = 1}, 1);
  std::string header = png.substr(16, 13);
  header.replace(4, 4, std::string("\0\0\x27\x10", 4));
  png = png.substr(0, 8) + test::png_chunk("IHDR", header) +
        test::png_chunk("IDAT", test::zlib_bytes("")) + test::png_chunk("IEND", "");
  expect_parts(input_error([&] { test::decoded(png); }), {"fewer pixels than it states"});
}

TEST(PngDecode, HeadersThatPngDoesNotHaveAreDamage) {
  const std::string png = random_png({.width = 8, .height = 6}, 1);
  for (const auto& [at, byte] :
       {std::pair(8, 3), {8, 32}, {9, 1}, {9, 5}, {10, 1}, {11, 1}, {12, 2}}) {
    std::string header = png.substr(16, 13);
    header[static_cast<std::size_t>(at)] = static_cast<char>(byte);
    const std::string other = png.substr(0, 8) + test::png_chunk("IHDR", header) + png.substr(33);
    expect_parts(input_error([&] { test::decoded(other); }), {"a kind that PNG does not have"});
  }
  expect_parts(input_error([&] { test::decoded(png.substr(0, 8) + png.substr(33)); }),
               {"does not begin with its header"});
}

TEST(PngDecode, AColourOutsideThePaletteIsDamage) {
  std::string png = random_png({.width = 64, .height = 64, .colour = 3}, 1);
  const std::size_t palette = png.find("PLTE") - 4;
  png.replace(palette, 12 + 3 * 256, test::png_chunk("PLTE", "abcdef"));
  expect_parts(input_error([&] { test::decoded(png); }), {"not in the palette"});
}

TEST(PngBytes, AreReadBackByOthersAndByUs) {
  std::mt19937 random(3);
  for (const int width : {1, 8, 333}) {
    GrayImage image{.width = width, .height = 20, .pixels = {}};
    for (int i = 0; i < width * 20; ++i)
      image.pixels.push_back(static_cast<std::uint8_t>(random()));
    const std::string png = png_bytes(image);
    EXPECT_EQ(test::decoded(png).pixels, image.pixels);
    EXPECT_EQ(test::decoded_by_opencv(png).pixels, image.pixels);
  }
}

TEST(RealPng, HasThePixelsOfLibpng) {
  const auto kitti = test::recordings();
  if (!kitti) GTEST_SKIP() << "skipped: no recordings";
  int images = 0;
  for (const auto& entry : std::filesystem::directory_iterator(
           kitti->parent_path() / "euroc/MH_01_easy_17s/mav0/cam0/data")) {
    if (++images > 20) break;
    const std::string png = test::slurp(entry.path());
    EXPECT_EQ(test::decoded(png).pixels, test::decoded_by_opencv(png).pixels) << entry.path();
  }
  EXPECT_GT(images, 20);
}

}  // namespace
}  // namespace chasles
