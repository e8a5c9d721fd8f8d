#include <chasles/codec/numbers.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/recording/testing.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;

// The difference of any two times that are read must be a time as well.
TEST(Parse, TimesAreReadWhereTheirDifferencesAreNanoseconds) {
  EXPECT_EQ(parse_nanoseconds("t", "1403636584763555584").count(), 1403636584763555584);
  EXPECT_EQ(parse_nanoseconds("t", "-4599999999999999999").count(), -4599999999999999999);
  EXPECT_EQ(parse_seconds("t", "4599999999.5").count(), 4599999999500000000);
  for (const char* text : {"4600000000000000000", "-9223372036854775808", "9223372036854775807"}) {
    expect_parts(input_error([&] { parse_nanoseconds("t", text); }),
                 {"t: found '", text, "expected nanoseconds below 4600000000000000000"});
  }
  for (const char* text : {"4600000000", "-4600000000", "9.1e9", "-1e300"}) {
    expect_parts(input_error([&] { parse_seconds("t", text); }), {"expected seconds below"});
  }
  const NumberArray late{.where = "t", .shape = {2}, .values = {0, 5e9}};
  expect_parts(input_error([&] { checked_times(late); }), {"expected seconds below 4600000000"});
}

}  // namespace
}  // namespace chasles
