#include <limits>

#include <gtest/gtest.h>

#include <chasles/recording/testing.hpp>
#include <chasles/video/gpmf.hpp>
#include <chasles/video/gpmf_testing.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;

std::vector<double> numbers(char type, std::size_t size, const std::string& data) {
  const GpmfItem item{
      .key = "TEST", .type = type, .size = size, .repeat = data.size() / size, .data = data};
  return gpmf_numbers(item, "file");
}

TEST(Gpmf, NumbersOfAllTypesAreRead) {
  using Numbers = std::vector<double>;
  EXPECT_EQ(numbers('b', 1, "\xff\x7f"), (Numbers{-1, 127}));
  EXPECT_EQ(numbers('B', 1, "\xff"), (Numbers{255}));
  EXPECT_EQ(numbers('s', 4, "\xff\xfe\x01\x02"), (Numbers{-2, 258}));
  EXPECT_EQ(numbers('S', 2, "\xff\xfe"), (Numbers{65534}));
  EXPECT_EQ(numbers('l', 4, std::string("\x80\0\0\0", 4)), (Numbers{-2147483648.0}));
  EXPECT_EQ(numbers('L', 4, std::string("\x80\0\0\0", 4)), (Numbers{2147483648.0}));
  EXPECT_EQ(numbers('j', 8, std::string(8, '\xff')), (Numbers{-1}));
  EXPECT_EQ(numbers('J', 8, test::big_endian_bytes(1ull << 40, 8)), (Numbers{1099511627776.0}));
  EXPECT_EQ(numbers('f', 4, std::string("\xc0\x20\0\0", 4)), (Numbers{-2.5}));
  EXPECT_EQ(numbers('d', 8, std::string("\xc0\x04\0\0\0\0\0\0", 8)), (Numbers{-2.5}));
  EXPECT_EQ(numbers('q', 4, std::string("\xff\xff\x80\0", 4)), (Numbers{-0.5}));
  EXPECT_EQ(numbers('Q', 8, std::string("\0\0\0\x02\x40\0\0\0", 8)), (Numbers{2.25}));
}

TEST(Gpmf, ItemsAreAlignedAndNested) {
  const std::string bytes = test::klv("ONE_", 'b', 1, 1, "\x05") +
                            test::nest("NEST", test::klv("TWO_", 'b', 1, 5, "\1\2\3\4\5")) +
                            std::string(8, '\0') + "behind the end";
  const auto items = gpmf_items(bytes, "file");
  ASSERT_EQ(items.size(), 2u);
  EXPECT_EQ(items[0].data, "\x05");
  ASSERT_TRUE(items[1].is_nest());
  const auto inner = gpmf_items(items[1].data, "file");
  ASSERT_EQ(inner.size(), 1u);
  EXPECT_EQ(inner[0].key, "TWO_");
  EXPECT_EQ(gpmf_numbers(inner[0], "file").size(), 5u);
}

TEST(Gpmf, AStreamHasWhatStandsBeforeItsSamples) {
  const std::string stream = test::klv_stamp("STMP", 80577) + test::klv_count("TSMP", 198) +
                             test::klv_text("STNM", "Accelerometer") +
                             test::klv_float("TIMO", 0.25f) + test::klv_text("ORIN", "XzY") +
                             test::klv_text("ORIO", "ZXY") + test::klv_text("SIUN", "m/s\xb2") +
                             test::klv_shorts("SCAL", {{10, 20, 40}}) +
                             test::klv_shorts("ACCL", {{10, 20, 40}, {-10, 0, 80}});
  const std::string payload = test::nest(
      "DEVC", test::klv_count("DVID", 1) + test::klv_text("DVNM", std::string("Max\0", 4)) +
                  test::nest("STRM", stream) + test::nest("STRM", test::klv_shorts("OTHR", {{1}})));
  const auto streams = gpmf_streams(payload, {"ACCL"}, "file");
  ASSERT_EQ(streams.size(), 2u);
  const GpmfSamples& s = streams[0];
  EXPECT_EQ(s.device, "1 Max");
  EXPECT_EQ(s.stamp, 80577u);
  EXPECT_EQ(s.total, 198u);
  EXPECT_EQ(s.delay, 0.25);
  EXPECT_EQ(s.axes_in, "XzY");
  EXPECT_EQ(s.axes_out, "ZXY");
  EXPECT_EQ(s.unit, "m/s2");
  EXPECT_EQ(s.samples, (std::vector<std::vector<double>>{{1, 1, 1}, {-1, 0, 2}}));
  EXPECT_EQ(streams[1].key, "OTHR");
  EXPECT_EQ(streams[1].count, 1u);
  EXPECT_TRUE(streams[1].samples.empty());  // not wanted
}

TEST(Gpmf, LyingSizesAndTypesAreErrorsWithTheirItem) {
  const auto rejected = [](const std::string& items) {
    return input_error(
        [&] { gpmf_streams(test::nest("DEVC", test::nest("STRM", items)), {"ACCL"}, "walk.mp4"); });
  };
  const std::string samples = test::klv_shorts("ACCL", {{1, 2, 3}});
  expect_parts(rejected(test::klv("ACCL", 's', 6, 60000, "123456")),
               {"walk.mp4: ACCL of 60000 samples of 6 bytes, type 's': only 8 bytes follow"});
  expect_parts(rejected(test::klv("ACCL", 's', 5, 2, "0123456789")), {"expected numbers"});
  expect_parts(rejected(test::klv("ACCL", 'x', 4, 1, "0123")), {"type 'x'", "expected numbers"});
  expect_parts(rejected(test::klv_shorts("SCAL", {{0}}) + samples), {"divisors other than 0"});
  expect_parts(rejected(test::klv_shorts("SCAL", {{1, 2}}) + samples), {"expected 2 channels"});
  expect_parts(rejected(test::klv_text("STMP", "now") + samples), {"expected one whole number"});
  expect_parts(rejected(test::klv_float("TIMO", std::numeric_limits<float>::infinity()) + samples),
               {"expected seconds"});
}

}  // namespace
}  // namespace chasles
