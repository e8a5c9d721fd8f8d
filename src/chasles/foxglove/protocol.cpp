#include <algorithm>
#include <array>
#include <limits>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/codec/utf8.hpp>
#include <chasles/foxglove/protocol.hpp>
#include <chasles/report/encode.hpp>
#include <chasles/viewers/byte_sink.hpp>

namespace chasles {
namespace {

using Ordered = nlohmann::ordered_json;

// The newest first.
constexpr std::array<std::string_view, 2> kSubprotocols = {"foxglove.sdk.v1",
                                                           "foxglove.websocket.v1"};
constexpr std::uint8_t kMessageData = 1, kTime = 2;  // opcodes
constexpr std::size_t kLongestQuote = 40;            // of a client's text, in a status [bytes]

/// Requests that ask for more than reading.
constexpr std::array<std::string_view, 10> kWrites = {"advertise",
                                                      "unadvertise",
                                                      "getParameters",
                                                      "setParameters",
                                                      "subscribeParameterUpdates",
                                                      "unsubscribeParameterUpdates",
                                                      "subscribeConnectionGraph",
                                                      "unsubscribeConnectionGraph",
                                                      "fetchAsset",
                                                      "playbackControlRequest"};

std::string_view trimmed(std::string_view text) {
  while (text.starts_with(' ') || text.starts_with('\t')) text.remove_prefix(1);
  while (text.ends_with(' ') || text.ends_with('\t')) text.remove_suffix(1);
  return text;
}

ClientFault fault(std::string why) { return {.why = std::move(why)}; }

/// A text of the client, short enough for a status.
std::string quoted(const std::string& text) {
  const bool is_long = text.size() > kLongestQuote;
  return fmt::format("'{}{}'", text.substr(0, kLongestQuote), is_long ? "…" : "");
}

bool is_id(const Ordered& value) {
  return value.is_number_unsigned() &&
         value.get<std::uint64_t>() <= std::numeric_limits<std::uint32_t>::max();
}

ClientMessage subscribe(const Ordered& json) {
  const auto list = json.find("subscriptions");
  if (list == json.end() || !list->is_array()) {
    return fault("subscribe: expected a list 'subscriptions'");
  }
  Subscribe message;
  for (const Ordered& one : *list) {
    if (!one.is_object() || !one.contains("id") || !one.contains("channelId") ||
        !is_id(one["id"]) || !is_id(one["channelId"])) {
      return fault("subscribe: expected 'id' and 'channelId' of each subscription, 32 bit numbers");
    }
    message.subscriptions.push_back(
        {.id = one["id"].get<std::uint32_t>(), .channel = one["channelId"].get<std::uint32_t>()});
  }
  return message;
}

ClientMessage unsubscribe(const Ordered& json) {
  const auto list = json.find("subscriptionIds");
  if (list == json.end() || !list->is_array() || !std::ranges::all_of(*list, is_id)) {
    return fault("unsubscribe: expected a list 'subscriptionIds' of 32 bit numbers");
  }
  return Unsubscribe{.ids = list->get<std::vector<std::uint32_t>>()};
}

}  // namespace

std::string_view foxglove_subprotocol(std::string_view offered) {
  for (const std::string_view ours : kSubprotocols) {
    for (std::string_view rest = offered; !rest.empty();) {
      const std::string_view one = rest.substr(0, rest.find(','));
      if (trimmed(one) == ours) return ours;
      rest.remove_prefix(std::min(rest.size(), one.size() + 1));
    }
  }
  return {};
}

bool is_foxglove_origin(std::string_view origin) {
  if (origin.empty() || origin == "file://" || origin == "https://app.foxglove.dev") return true;
  for (const std::string_view scheme : {"http://", "https://"}) {
    if (!origin.starts_with(scheme)) continue;
    const std::string_view host = origin.substr(scheme.size());
    for (const std::string_view own : {"localhost", "127.0.0.1", "[::1]"}) {
      if (!host.starts_with(own)) continue;
      const std::string_view port = host.substr(own.size());
      const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
      if (port.empty() || (port.size() > 1 && port.front() == ':' &&
                           std::ranges::all_of(port.substr(1), is_digit))) {
        return true;
      }
    }
  }
  return false;
}

std::string server_info_text(std::string_view name, std::string_view session) {
  return json_text({{"op", "serverInfo"},
                    {"name", name},
                    {"capabilities", Ordered::array({"time"})},
                    {"sessionId", session}});
}

std::string status_text(StatusLevel level, std::string_view message) {
  return json_text({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", message}});
}

std::string advertise_text(const std::vector<AdvertisedChannel>& channels) {
  Ordered list = Ordered::array();
  for (const AdvertisedChannel& channel : channels) {
    list.push_back({{"id", channel.id},
                    {"topic", channel.topic.topic},
                    {"encoding", "protobuf"},
                    {"schemaName", channel.topic.schema},
                    {"schema", base64({channel.descriptors.begin(), channel.descriptors.end()})},
                    {"schemaEncoding", "protobuf"}});
  }
  return json_text({{"op", "advertise"}, {"channels", std::move(list)}});
}

std::string message_frame(std::uint32_t subscription, Time time, std::string_view data) {
  std::string frame;
  frame.reserve(data.size() + 13);
  append_little_endian(frame, kMessageData);
  append_little_endian(frame, subscription);
  append_little_endian(frame, static_cast<std::uint64_t>(time.count()));
  frame += data;
  return frame;
}

std::string time_frame(Time time) {
  std::string frame;
  append_little_endian(frame, kTime);
  append_little_endian(frame, static_cast<std::uint64_t>(time.count()));
  return frame;
}

ClientMessage parse_client_message(std::string_view message, bool binary) {
  if (binary) return fault("found a binary message: this server only sends, it takes no data");
  const Ordered json = Ordered::parse(message, nullptr, false);
  if (!json.is_object() || !json.contains("op") || !json["op"].is_string()) {
    return fault("expected a json object with 'op'");
  }
  const std::string& op = json["op"].get_ref<const std::string&>();
  if (op == "subscribe") return subscribe(json);
  if (op == "unsubscribe") return unsubscribe(json);
  if (std::ranges::find(kWrites, op) != kWrites.end()) {
    return fault(fmt::format("'{}' is not supported: this server only sends", op));
  }
  return fault(fmt::format("found op {}, expected 'subscribe' or 'unsubscribe'", quoted(op)));
}

}  // namespace chasles
