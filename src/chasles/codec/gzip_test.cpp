#include <chasles/codec/gzip.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/testing.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;

// The output of gzip 1.12 and Python for forty lines, with the name of the file in the header.
const std::string& zipped() {
  static constexpr char kBytes[] =
      "\x1f\x8b\x08\x08\x00\x00\x00\x00\x02\xff\x74\x72\x75\x74\x68\x2e"
      "\x74\x75\x6d\x00\x33\xd0\x33\x55\x30\x54\x30\x52\x30\x56\x30\x00"
      "\x43\x43\x2e\x83\x51\x91\x51\x91\x21\x2b\x02\x00\xdb\xde\xd1\x5d"
      "\xd0\x02\x00\x00";
  static const std::string bytes(kBytes, sizeof(kBytes) - 1);
  return bytes;
}

std::string content() {
  std::string text;
  for (int i = 0; i < 40; ++i) text += "0.5 1 2 3 0 0 0 1\n";
  return text;
}

TEST(Gzip, GivesTheContentBack) {
  ASSERT_TRUE(is_gzip(zipped()));
  EXPECT_EQ(gunzip(zipped(), "file"), content());
}

TEST(Gzip, EveryOptionalFieldOfTheHeaderIsSkipped) {
  // Extra field, name, comment and check sum of the header, before the same deflated bytes.
  std::string bytes = zipped();
  const std::size_t begin = 10 + std::string("truth.tum").size() + 1;
  bytes[3] = 2 | 4 | 8 | 16;
  bytes = bytes.substr(0, 10) + std::string("\x03\0abc", 5) + std::string("n\0", 2) +
          std::string("c\0", 2) + "hc" + bytes.substr(begin);
  EXPECT_EQ(gunzip(bytes, "file"), content());
}

TEST(Gzip, AFileIsReadEitherWay) {
  const auto folder = test::scratch();
  test::spill(folder / "a", zipped());
  test::spill(folder / "b", content());
  EXPECT_EQ(read_plain_or_gzip(folder / "a"), content());
  EXPECT_EQ(read_plain_or_gzip(folder / "b"), content());
}

TEST(Gzip, ATrajectoryMayBeCompressed) {
  const auto file = test::scratch() / "truth.tum";
  test::spill(file, zipped());
  // Its forty times do not rise: an error of the content, not of its compression.
  expect_parts(input_error([&] { read_tum(file); }), {"truth.tum:2", "rise strictly"});
}

TEST(Gzip, EveryTruncationIsNoticed) {
  for (std::size_t size = 0; size < zipped().size(); ++size) {
    expect_parts(input_error([&] { gunzip(zipped().substr(0, size), "the file"); }), {"the file"});
  }
}

TEST(Gzip, NoDamagedByteGivesOtherContent) {
  int noticed = 0;
  for (std::size_t i = 0; i < zipped().size(); ++i) {
    std::string bytes = zipped();
    bytes[i] = static_cast<char>(bytes[i] ^ 0x24);
    try {
      EXPECT_EQ(gunzip(bytes, "file"), content()) << "byte " << i;
    } catch (const InputError&) {
      ++noticed;
    }
  }
  // All bytes except time, level, system and name.
  EXPECT_GE(noticed, static_cast<int>(zipped().size()) - 16);
}

TEST(Gzip, ALyingSizeTakesNoMemory) {
  std::string bytes = zipped();
  bytes[bytes.size() - 1] = '\x7f';
  expect_parts(input_error([&] { gunzip(bytes, "file"); }), {"claims 2130707152 bytes"});
}

}  // namespace
}  // namespace chasles
