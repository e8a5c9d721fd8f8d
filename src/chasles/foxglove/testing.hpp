#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chasles/foxglove/service.hpp>
#include <chasles/foxglove/session.hpp>
#include <chasles/report/testing.hpp>

/// Shared by the tests of this folder: a client that reads the protocol by its description.
namespace chasles::test {

/// A number of `bytes` bytes in little-endian order.
inline std::uint64_t number_at(std::string_view text, std::size_t at, std::size_t bytes) {
  std::uint64_t value = 0;
  for (std::size_t k = bytes; k-- > 0;)
    value = value << 8 | static_cast<unsigned char>(text[at + k]);
  return value;
}

/// What a client has received.
struct Watcher {
  nlohmann::json info = nullptr;
  std::vector<nlohmann::json> statuses = {};
  std::map<std::string, std::uint32_t> channels = {};               ///< by topic
  std::map<std::uint32_t, std::vector<std::string>> messages = {};  ///< by subscription
  std::vector<Time> times = {}, clock = {};                         ///< of the messages; sent

  void take(std::string_view bytes, bool binary) { binary ? take_frame(bytes) : take_text(bytes); }

  /// Everything that the session has to say at present.
  void drain(FoxgloveSession& session) {
    while (const LiveMessage message = session.next()) take(*message.bytes, message.binary);
  }
  /// Subscribes to these topics, with their channels' numbers plus 100.
  std::string subscription(const std::vector<std::string>& topics) const {
    nlohmann::json list = nlohmann::json::array();
    for (const std::string& topic : topics) {
      list.push_back({{"id", id(topic)}, {"channelId", channels.at(topic)}});
    }
    return nlohmann::json({{"op", "subscribe"}, {"subscriptions", list}}).dump();
  }
  std::uint32_t id(const std::string& topic) const { return channels.at(topic) + 100; }
  std::size_t count(const std::string& topic) const {
    const auto found = messages.find(id(topic));
    return found == messages.end() ? 0 : found->second.size();
  }

 private:
  void take_text(std::string_view text) {
    const auto json = nlohmann::json::parse(text);
    const auto op = json.at("op").get<std::string>();
    if (op == "serverInfo") info = json;
    if (op == "status") statuses.push_back(json);
    if (op != "advertise") return;
    for (const auto& channel : json.at("channels")) {
      EXPECT_TRUE(channels.emplace(channel.at("topic"), channel.at("id")).second);
    }
  }
  void take_frame(std::string_view frame) {
    if (frame.at(0) == 2) {
      ASSERT_EQ(frame.size(), 9u);
      clock.emplace_back(static_cast<std::int64_t>(number_at(frame, 1, 8)));
      return;
    }
    ASSERT_EQ(frame.at(0), 1);
    times.emplace_back(static_cast<std::int64_t>(number_at(frame, 5, 8)));
    messages[static_cast<std::uint32_t>(number_at(frame, 1, 4))].emplace_back(frame.substr(13));
  }
};

/// A run before its first state.
inline FoxgloveStart foxglove_start(const ReportRun& drive, int cameras = 0,
                                    bool pictures = false) {
  FoxgloveStart start{
      .header = {}, .summary = drive.summary, .cameras = cameras, .pictures = pictures};
  start.header.name = drive.run.name;
  start.header.extra_names = drive.run.extra_names;
  start.header.truth = drive.run.truth;
  start.header.dead_reckoning = drive.run.dead_reckoning;
  start.header.georeference = drive.run.georeference;
  return start;
}

}  // namespace chasles::test
