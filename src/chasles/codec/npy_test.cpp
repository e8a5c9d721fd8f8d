#include <chasles/codec/npy.hpp>
#include <chasles/recording/testing.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;
using test::npy_header;

NpyHeader parse(const std::string& dict, char version = 1) {
  const std::string header = npy_header(dict, version);
  EXPECT_EQ(npy_header_size(header.substr(0, kNpyPreamble), "f"), header.size());
  return parse_npy_header(header, "f");
}

TEST(NpyHeader, ShowsTypeOrderAndShape) {
  const NpyHeader header =
      parse("{'descr': '<f4', 'fortran_order': True, 'shape': (4, 260, 1104), }");
  EXPECT_EQ(header.type, NpyType::kFloat32);
  EXPECT_TRUE(header.fortran_order);
  EXPECT_EQ(header.shape, (std::vector<std::size_t>{4, 260, 1104}));
  EXPECT_EQ(header.count, 4u * 260 * 1104);
}

TEST(NpyHeader, ASingleNumberHasAnEmptyShape) {
  const NpyHeader header = parse("{'descr': '<f8', 'fortran_order': False, 'shape': (), }");
  EXPECT_TRUE(header.shape.empty());
  EXPECT_EQ(header.count, 1u);
}

TEST(NpyHeader, TheOrderOfKeysBlanksAndQuotesIsFree) {
  const NpyHeader header =
      parse("{\"shape\":(3L,) ,\"descr\" : \"|i1\",\"fortran_order\":False}", 2);
  EXPECT_EQ(header.shape, (std::vector<std::size_t>{3}));
  EXPECT_EQ(header.type, NpyType::kInt8);
}

TEST(NpyHeader, EveryTypeIsTurnedIntoTheSameNumbers) {
  const std::vector<double> expected{0, 1, 100};
  const auto check = [&]<typename T>(NpyType type, T) {
    std::string bytes;
    for (const double value : expected) test::append_raw<T>(bytes, value);
    EXPECT_EQ(npy_size(type), sizeof(T));
    std::vector<double> found(expected.size());
    npy_to_double(type, bytes, found.data());
    EXPECT_EQ(found, expected);
  };
  check(NpyType::kFloat64, double{});
  check(NpyType::kFloat32, float{});
  check(NpyType::kInt8, std::int8_t{});
  check(NpyType::kInt16, std::int16_t{});
  check(NpyType::kInt32, std::int32_t{});
  check(NpyType::kInt64, std::int64_t{});
  check(NpyType::kUint8, std::uint8_t{});
  check(NpyType::kUint16, std::uint16_t{});
  check(NpyType::kUint32, std::uint32_t{});
  check(NpyType::kUint64, std::uint64_t{});
}

TEST(NpyHeader, ForeignTypesAreRejectedByName) {
  for (const std::string descr : {"|O", ">f8", "<c16", "<U8", "<f2", ""}) {
    expect_parts(input_error([&] {
                   parse("{'descr': '" + descr + "', 'fortran_order': False, 'shape': (3,), }");
                 }),
                 {"f: has dtype '" + descr + "'", "expected little-endian real numbers"});
  }
  expect_parts(input_error([] {
                 parse("{'descr': [('a', '<f8')], 'fortran_order': False, 'shape': (3,), }");
               }),
               {"records"});
}

TEST(NpyHeader, MalformedDictionariesAreRejected) {
  for (const std::string dict :
       {"", "{", "{'descr'", "{'descr': '<f8'", "{'descr': '<f8'}", "[]",
        "{'descr': '<f8', 'fortran_order': 0, 'shape': (3,), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (-3,), }",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (3", "{'other': 1}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (3, 'a'), }"}) {
    expect_parts(input_error([&] { parse(dict); }), {"f: the .npy header"});
  }
}

TEST(NpyHeader, SizesThatOverflowAreRejected) {
  expect_parts(
      input_error([] {
        parse("{'descr': '<f8', 'fortran_order': False, 'shape': (4294967296, 4294967296), }");
      }),
      {"claims more than 2^32 numbers"});
}

TEST(NpyHeader, ForeignBytesVersionsAndLengthsAreRejected) {
  expect_parts(input_error([] { npy_header_size("abcdefghijkl", "f"); }), {"is not an .npy array"});
  expect_parts(input_error([] { npy_header_size("\x93NUMPY", "f"); }), {"is not an .npy array"});
  std::string header = npy_header("{}");
  header[6] = 9;
  expect_parts(input_error([&] { npy_header_size(header, "f"); }), {"has version 9.0"});
  header = npy_header("{}", 2);
  header[11] = '\x7f';
  expect_parts(input_error([&] { npy_header_size(header, "f"); }), {"claims", "at most 65536"});
}

}  // namespace
}  // namespace chasles
