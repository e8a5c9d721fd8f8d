#include <string>

#include <gtest/gtest.h>

#include <chasles/live/viewer_message.hpp>

namespace chasles {
namespace {

TEST(ViewerMessage, SaysWhatTheViewerHas) {
  const auto message = parse_viewer_message(
      R"({"join": {"run": "ab", "rows": 12, "landmarks": 3, "truth": true, "map": true,
          "all": false}})");
  ASSERT_TRUE(message && message->join);
  EXPECT_EQ(message->join->run, "ab");
  EXPECT_EQ(message->join->rows, 12U);
  EXPECT_EQ(message->join->landmarks, 3U);
  EXPECT_TRUE(message->join->truth);
  EXPECT_TRUE(message->join->prior_map);
  EXPECT_FALSE(message->join->all || message->stop);
  EXPECT_EQ(parse_viewer_message(R"({"join": {}})")->join->rows, 0U);
  EXPECT_TRUE(parse_viewer_message(R"({"stop": true})")->stop);
}

TEST(ViewerMessage, AnythingElseIsNone) {
  const std::string deep(3000, '[');
  for (const std::string& text :
       {std::string(), std::string("{"), std::string("[]"), std::string("{}"), deep,
        std::string(R"({"stop": false})"), std::string(R"({"stop": 1})"),
        std::string(R"({"join": {"rows": -1}})"), std::string(R"({"join": {"rows": 1.5}})"),
        std::string(R"({"join": {"rows": 1e99}})"), std::string(R"({"join": {"run": 3}})"),
        std::string(R"({"join": {"truth": 1}})"), std::string(R"({"join": []})"),
        std::string(R"({"join": {}, "stop": true})"), std::string(R"({"other": 1})"),
        R"({"join": {"run": ")" + std::string(65, 'a') + "\"}}", std::string("\xff\xfe")}) {
    EXPECT_FALSE(parse_viewer_message(text)) << text.substr(0, 60);
  }
}

}  // namespace
}  // namespace chasles
