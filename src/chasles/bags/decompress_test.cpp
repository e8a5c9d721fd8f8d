#include <bzlib.h>
#include <zstd.h>

#include <lz4frame.h>

#include <chasles/bags/decompress.hpp>
#include <chasles/recording/testing.hpp>

namespace chasles {
namespace {

using test::expect_parts;
using test::input_error;

std::string packed(const std::string& text, const std::string& compression) {
  std::string bytes(text.size() + 10'000, '\0');
  std::size_t size = 0;
  if (compression == "bz2") {
    auto length = static_cast<unsigned>(bytes.size());
    std::string source = text;
    BZ2_bzBuffToBuffCompress(bytes.data(), &length, source.data(),
                             static_cast<unsigned>(source.size()), 9, 0, 0);
    size = length;
  } else if (compression == "lz4") {
    size = LZ4F_compressFrame(bytes.data(), bytes.size(), text.data(), text.size(), nullptr);
  } else {
    size = ZSTD_compress(bytes.data(), bytes.size(), text.data(), text.size(), 3);
  }
  return bytes.substr(0, size);
}

TEST(Decompress, WhatIsPackedComesBack) {
  std::string text;
  for (int i = 0; i < 40'000; ++i) text += std::to_string(i * i);
  for (const char* name : {"bz2", "lz4", "zstd"}) {
    EXPECT_EQ(decompress(packed(text, name), name, text.size(), "chunk"), text) << name;
    EXPECT_EQ(decompress(packed("", name), name, 0, "chunk"), "") << name;
  }
  EXPECT_EQ(decompress("abc", "none", 3, "chunk"), "abc");
}

TEST(Decompress, MoreThanStatedAndLessThanWholeAreRejected) {
  const std::string text(3'000'000, 'x');
  for (const char* name : {"bz2", "lz4", "zstd"}) {
    const std::string bytes = packed(text, name);
    expect_parts(input_error([&] { decompress(bytes, name, 1'000'000, "chunk"); }),
                 {"chunk: decompresses to more than 1000000 bytes"});
    for (std::size_t size = 0; size < bytes.size(); size += 1 + bytes.size() / 20) {
      expect_parts(input_error([&] { decompress(bytes.substr(0, size), name, 1 << 28, "chunk"); }),
                   {"chunk: cannot be decompressed"});
    }
  }
  expect_parts(input_error([&] { decompress("abc", "zlib", 3, "chunk"); }), {"'zlib'"});
}

}  // namespace
}  // namespace chasles
