#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chasles/codec/utf8.hpp>

namespace chasles {
namespace {

std::string encoded(unsigned code) {
  const auto tail = [code](unsigned shift) {
    return static_cast<char>(0x80 | (code >> shift & 63));
  };
  if (code < 0x80) return {static_cast<char>(code)};
  if (code < 0x800) return {static_cast<char>(0xc0 | code >> 6), tail(0)};
  if (code < 0x10000) return {static_cast<char>(0xe0 | code >> 12), tail(6), tail(0)};
  return {static_cast<char>(0xf0 | code >> 18), tail(12), tail(6), tail(0)};
}

TEST(Utf8, ItsCharactersStayAsTheyAre) {
  for (unsigned code = 0; code < 0x110000; code += code < 0x3000 ? 1 : 97) {
    if (code >= 0xd800 && code < 0xe000) continue;
    const std::string character = encoded(code), text = character + "b" + character;
    ASSERT_EQ(valid_utf8(text), text) << code;
  }
  EXPECT_EQ(valid_utf8(encoded(0x10ffff)), encoded(0x10ffff));
  EXPECT_EQ(valid_utf8(""), "");
}

// RFC 3629, section 3 and 4, against nlohmann's own check of what it parses.
TEST(Utf8, WhateverIsNoneIsReplacedAndTheRestStays) {
  const std::string r = "\xef\xbf\xbd";
  EXPECT_EQ(valid_utf8("caf\xe9"), "caf" + r) << "Latin-1";
  EXPECT_EQ(valid_utf8("\xe9t\xe9"), r + "t" + r) << "a character's begin without its end";
  EXPECT_EQ(valid_utf8("\xc0\xaf"), r + r) << "/ in two bytes";
  EXPECT_EQ(valid_utf8("\xe0\x80\xaf"), r + r + r) << "/ in three";
  EXPECT_EQ(valid_utf8("\xed\xa0\x80"), r + r + r) << "half of a surrogate pair";
  EXPECT_EQ(valid_utf8("\xf4\x90\x80\x80"), r + r + r + r) << "beyond the last character";
  EXPECT_EQ(valid_utf8("\xf0\x9f\x9a"), r + r + r) << "cut off";
  for (unsigned first = 0; first < 256; ++first) {
    for (unsigned second = 0; second < 256; ++second) {
      const std::string bytes = {static_cast<char>(first), static_cast<char>(second), 'x'};
      std::string text = "\"";
      for (const char c : valid_utf8(bytes)) {
        if (static_cast<unsigned char>(c) >= 0x20 && c != '"' && c != '\\') text += c;
      }
      ASSERT_TRUE(nlohmann::json::accept(text + "\"")) << first << " " << second;
    }
  }
}

TEST(Utf8, JsonTextIsValidJsonWhateverItsStringsHold) {
  const nlohmann::ordered_json json = {{"name", "caf\xe9"}, {"\xff", 1}};
  const auto read = nlohmann::ordered_json::parse(json_text(json, 2));
  EXPECT_EQ(read.at("name"), "caf\xef\xbf\xbd");
  EXPECT_EQ(read.at("\xef\xbf\xbd"), 1);
}

TEST(Utf8, PrintableTextCommandsNoTerminal) {
  EXPECT_EQ(printable("a\tb\nMüller"), "a\tb\nMüller");
  EXPECT_EQ(printable("\x1b[31m\x07\r\x7f"), "\\u001b[31m\\u0007\\u000d\\u007f");
  EXPECT_EQ(printable("\xc2\x9b\xc2\xa0\xff"), "\\u009b\xc2\xa0\xef\xbf\xbd");
  const nlohmann::ordered_json json = {{"name", "\x1b\x7f\xc2\x85"}};
  EXPECT_EQ(nlohmann::ordered_json::parse(printable(json_text(json))), json);
}

}  // namespace
}  // namespace chasles
