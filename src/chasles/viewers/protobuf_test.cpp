#include <stdexcept>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chasles/viewers/protobuf.hpp>

namespace chasles {
namespace {

using namespace std::string_literals;

ProtoSchemas schemas() {
  ProtoSchemas all;
  all["p.Inner"] = proto_message("p.Inner", {"double x = 1"});
  all["p.Outer"] = proto_message(
      "p.Outer",
      {"int32 n = 1", "string s = 2", "p.Inner inner = 3", "repeated fixed32 list = 4",
       "Kind kind = 5", "bytes data = 200", "bool yes = 6"},
      {{"Kind", {"NONE", "SOME"}}});
  return all;
}

std::string bytes(const nlohmann::json& value) { return proto_bytes(schemas(), "p.Outer", value); }

// The examples of the encoding's documentation: 150 is 96 01, "testing" has tag 12 and length 7.
TEST(Protobuf, BytesAreThoseOfTheWireFormat) {
  EXPECT_EQ(bytes({{"n", 150}}), "\x08\x96\x01"s);
  EXPECT_EQ(bytes({{"n", -1}}), "\x08\xff\xff\xff\xff\xff\xff\xff\xff\xff\x01"s);
  EXPECT_EQ(bytes({{"s", "testing"}}), "\x12\x07testing"s);
  EXPECT_EQ(bytes({{"inner", {{"x", 1.0}}}}), "\x1a\x09\x09\0\0\0\0\0\0\xf0\x3f"s);
  EXPECT_EQ(bytes({{"list", {1, 258}}}), "\x22\x08\x01\0\0\0\x02\x01\0\0"s);
  EXPECT_EQ(bytes({{"kind", 1}, {"yes", true}}), "\x28\x01\x30\x01"s);
  EXPECT_EQ(bytes({{"data", nlohmann::json::binary({7})}}), "\xc2\x0c\x01\x07"s);
}

TEST(Protobuf, WhatASchemaDoesNotHaveIsRejected) {
  EXPECT_THROW(bytes({{"m", 1}}), std::invalid_argument);
  EXPECT_THROW(proto_message("p.M", {"double x"}), std::invalid_argument);
  EXPECT_THROW(proto_message("p.M", {"Kind x = 1"}), std::invalid_argument);
}

}  // namespace
}  // namespace chasles
