#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chasles/foxglove/protocol.hpp>

namespace chasles {
namespace {

using Json = nlohmann::json;

TEST(FoxgloveProtocol, TheSubprotocolIsChosenAmongThoseThatAreOffered) {
  EXPECT_EQ(foxglove_subprotocol("foxglove.websocket.v1"), "foxglove.websocket.v1");
  EXPECT_EQ(foxglove_subprotocol("chat, foxglove.sdk.v1"), "foxglove.sdk.v1");
  EXPECT_EQ(foxglove_subprotocol(" foxglove.websocket.v1 ,\tfoxglove.sdk.v1"), "foxglove.sdk.v1");
  for (const char* none : {"", ",", "chat", "foxglove.websocket.v2", "xfoxglove.sdk.v1",
                           "foxglove.sdk.v1x", "foxglove.websocket.v1 foxglove.sdk.v1"}) {
    EXPECT_EQ(foxglove_subprotocol(none), "") << none;
  }
}

TEST(FoxgloveProtocol, OnlyFoxglovesPagesAndThoseOfThisMachineMayConnect) {
  for (const char* origin :
       {"", "file://", "https://app.foxglove.dev", "http://localhost", "http://localhost:8080",
        "https://localhost:8443", "http://127.0.0.1:8080", "http://[::1]:8080"}) {
    EXPECT_TRUE(is_foxglove_origin(origin)) << origin;
  }
  for (const char* origin :
       {"null", "file:///home", "https://evil.example", "https://app.foxglove.dev.evil.example",
        "http://app.foxglove.dev", "https://foxglove.dev", "https://app.foxglove.dev:444",
        "http://localhost.evil.example", "http://localhost:", "http://localhost:80@evil.example",
        "http://127.0.0.1.evil.example", "http://127.0.0.11:8080", "ftp://localhost",
        "localhost"}) {
    EXPECT_FALSE(is_foxglove_origin(origin)) << origin;
  }
}

TEST(FoxgloveProtocol, FramesHaveTheirNumbersInLittleEndian) {
  const Time time(0x0102030405060708);
  EXPECT_EQ(message_frame(0xa0b0c0d0, time, "xyz"),
            std::string("\x01\xd0\xc0\xb0\xa0\x08\x07\x06\x05\x04\x03\x02\x01xyz"));
  EXPECT_EQ(time_frame(time), std::string("\x02\x08\x07\x06\x05\x04\x03\x02\x01"));
}

TEST(FoxgloveProtocol, TextsAreJsonWhateverTheNames) {
  const Json info = Json::parse(server_info_text("caf\xe9", "id"));
  EXPECT_EQ(info.at("op"), "serverInfo");
  EXPECT_EQ(info.at("name"), "caf\xef\xbf\xbd");
  EXPECT_EQ(info.at("capabilities"), Json::array({"time"}));
  EXPECT_EQ(Json::parse(status_text(StatusLevel::kWarning, "\"\n")).at("level"), 1);
  const Json advertised = Json::parse(advertise_text(
      {{.id = 7, .topic = {"/pose", "foxglove.PoseInFrame"}, .descriptors = "foobar"}}));
  EXPECT_EQ(advertised.at("channels").at(0).at("schema"), "Zm9vYmFy");
  EXPECT_EQ(advertised.at("channels").at(0).at("id"), 7);
}

TEST(FoxgloveProtocol, SubscriptionsAreRead) {
  const ClientMessage message = parse_client_message(
      R"({"op": "subscribe", "subscriptions": [{"id": 0, "channelId": 4294967295},
          {"id": 3, "channelId": 1, "more": null}]})",
      false);
  const auto& list = std::get<Subscribe>(message).subscriptions;
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0].channel, std::numeric_limits<std::uint32_t>::max());
  EXPECT_EQ(list[1].id, 3u);
  const ClientMessage end =
      parse_client_message(R"({"op": "unsubscribe", "subscriptionIds": [3, 0]})", false);
  EXPECT_EQ(std::get<Unsubscribe>(end).ids, (std::vector<std::uint32_t>{3, 0}));
}

TEST(FoxgloveProtocol, OtherMessagesAreFaultsThatSayWhatIsWrong) {
  const auto why = [](std::string_view text, bool binary = false) {
    const ClientMessage message = parse_client_message(text, binary);
    const auto* fault = std::get_if<ClientFault>(&message);
    return fault ? fault->why : "no fault";
  };
  const auto has = [](const std::string& text, const std::string& part) {
    return text.find(part) != std::string::npos;
  };
  for (const std::string& text :
       {std::string(), std::string("nonsense"), std::string("[]"), std::string("{}"),
        std::string(R"({"op": 1})"), std::string("\xff\xfe"), std::string(60'000, '['),
        R"({"op":)" + std::string(60'000, '[')}) {
    EXPECT_EQ(why(text), "expected a json object with 'op'") << text.substr(0, 20);
  }
  EXPECT_TRUE(has(why("\x01\x01\x02\x03\x04", true), "it takes no data"));
  for (const char* op :
       {"advertise", "setParameters", "getParameters", "fetchAsset", "subscribeConnectionGraph"}) {
    EXPECT_TRUE(has(why(std::string(R"({"op": ")") + op + "\"}"), "this server only sends")) << op;
  }
  EXPECT_EQ(why(R"({"op": "fly"})"), "found op 'fly', expected 'subscribe' or 'unsubscribe'");
  EXPECT_LT(why(R"({"op": ")" + std::string(60'000, 'x') + "\"}").size(), 120u);
  for (const char* list :
       {"", R"(, "subscriptions": 1)", R"(, "subscriptions": [1])",
        R"(, "subscriptions": [{"id": 1}])", R"(, "subscriptions": [{"id": -1, "channelId": 1}])",
        R"(, "subscriptions": [{"id": 1, "channelId": 4294967296}])",
        R"(, "subscriptions": [{"id": 1.5, "channelId": 1}])"}) {
    EXPECT_TRUE(has(why(std::string(R"({"op": "subscribe")") + list + "}"), "subscribe: expected"))
        << list;
  }
  EXPECT_TRUE(
      has(why(R"({"op": "unsubscribe", "subscriptionIds": ["1"]})"), "unsubscribe: expected"));
}

// Bytes of valid messages are replaced, removed and doubled: whatever comes, there is an answer.
TEST(FoxgloveProtocol, MutatedMessagesAreReadOrAreFaults) {
  const std::string valid[] = {
      R"({"op": "subscribe", "subscriptions": [{"id": 12, "channelId": 3}, {"id": 2, "channelId": 1}]})",
      R"({"op": "unsubscribe", "subscriptionIds": [1, 22, 333]})",
      R"({"op": "advertise", "channels": [{"id": 1, "topic": "t", "encoding": "json"}]})"};
  std::mt19937 random(7);  // its numbers are the same everywhere
  int faults = 0, read = 0;
  for (int k = 0; k < 20'000; ++k) {
    std::string text = valid[k % 3];
    for (auto changes = 1 + random() % 3; changes > 0; --changes) {
      const std::size_t at = random() % text.size();
      switch (random() % 3) {
        case 0:
          text[at] = static_cast<char>(random() % 256);
          break;
        case 1:
          text.erase(at, 1 + random() % 4);
          break;
        default:
          text.insert(at, text.substr(random() % text.size(), random() % 8));
      }
    }
    const ClientMessage message = parse_client_message(text, false);
    const auto* fault = std::get_if<ClientFault>(&message);
    fault ? ++faults : ++read;
    if (fault) {
      EXPECT_TRUE(Json::accept(status_text(StatusLevel::kError, fault->why))) << text;
    }
  }
  EXPECT_GT(faults, 1000);
  EXPECT_GT(read, 100);
}

}  // namespace
}  // namespace chasles
