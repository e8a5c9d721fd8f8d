#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <chasles/base/time.hpp>
#include <chasles/viewers/topics.hpp>

// Foxglove's WebSocket protocol, as a server speaks it: foxglove.websocket.v1 and its successor
// foxglove.sdk.v1, which have the same messages (github.com/foxglove/ws-protocol, its
// specification; github.com/foxglove/foxglove-sdk).
namespace chasles {

/// Chooses a subprotocol of the header Sec-WebSocket-Protocol; empty if none is Foxglove's.
std::string_view foxglove_subprotocol(std::string_view offered);

/// Whether a page of this origin may connect: Foxglove's app as a page or on the desktop, a page of
/// this machine, or a program other than a browser (empty).
bool is_foxglove_origin(std::string_view origin);

/// The level of a status message.
enum class StatusLevel { kInfo = 0, kWarning = 1, kError = 2 };

// Texts of the server.
std::string server_info_text(std::string_view name, std::string_view session);
std::string status_text(StatusLevel level, std::string_view message);

struct AdvertisedChannel {
  std::uint32_t id = 0;
  ViewerTopic topic;
  std::string descriptors;  ///< the serialised FileDescriptorSet of the schema
};
std::string advertise_text(const std::vector<AdvertisedChannel>& channels);

// Binary messages of the server. Times are from 1970 on.
std::string message_frame(std::uint32_t subscription, Time time, std::string_view data);
std::string time_frame(Time time);

// Messages of a client.
struct Subscribe {
  struct One {
    std::uint32_t id = 0, channel = 0;
  };
  std::vector<One> subscriptions;
};
struct Unsubscribe {
  std::vector<std::uint32_t> ids;
};
/// A message that is not of the protocol, or that asks for more than reading.
struct ClientFault {
  std::string why;  ///< for the client: found, expected
};
using ClientMessage = std::variant<Subscribe, Unsubscribe, ClientFault>;

ClientMessage parse_client_message(std::string_view message, bool binary);

}  // namespace chasles
