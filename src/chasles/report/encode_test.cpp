#include <cmath>

#include <gtest/gtest.h>

#include <chasles/base/constants.hpp>
#include <chasles/report/encode.hpp>
#include <chasles/report/testing.hpp>

namespace chasles {
namespace {

using test::column;
using test::planes_of;

std::string as_base64(const std::string& text) { return base64({text.begin(), text.end()}); }

TEST(Encode, Base64GivesTheVectorsOfRfc4648) {
  EXPECT_EQ(as_base64(""), "");
  EXPECT_EQ(as_base64("f"), "Zg==");
  EXPECT_EQ(as_base64("fo"), "Zm8=");
  EXPECT_EQ(as_base64("foo"), "Zm9v");
  EXPECT_EQ(as_base64("foob"), "Zm9vYg==");
  EXPECT_EQ(as_base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(as_base64("foobar"), "Zm9vYmFy");
  EXPECT_EQ(base64({0xff, 0xfb, 0xf0}), "//vw");
}

TEST(Encode, ColumnsAreLittleEndianInPlanes) {
  using namespace std::string_literals;
  EXPECT_EQ(planes_of(float_column({1.0, -2.0})), "\0\0\0\0\x80\0\x3f\xc0"s);
  EXPECT_EQ(planes_of(double_column({1.0})), "\0\0\0\0\0\0\xf0\x3f"s);
  EXPECT_EQ(planes_of(int_column({1, -1})), "\x01\xff\0\xff\0\xff\0\xff"s);
  EXPECT_EQ(float_column({1.0}).substr(0, 4), "f32:");
  EXPECT_EQ(planes_of(float_column({})), "");
  EXPECT_TRUE(std::isnan(column(float_column({kNaN}))[0]));
}

}  // namespace
}  // namespace chasles
