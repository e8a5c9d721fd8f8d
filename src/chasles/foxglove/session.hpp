#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>

#include <chasles/foxglove/foxglove_channels.hpp>
#include <chasles/live/service.hpp>

namespace chasles {

/// One client of Foxglove's protocol. It chooses channels, and gets their messages in the order of
/// time as fast as it takes them: no message waits in a queue, because each is made when the one
/// before has been sent. A client that is not of the protocol hears so in status messages.
class FoxgloveSession final : public LiveSession {
 public:
  /// Faults of a client; one more, and its connection is closed.
  static constexpr int kMostFaults = 100;
  static constexpr std::size_t kMostReplies = 16;  ///< status messages that wait to be sent

  /// `server`: name and version of the program. The channels must outlive the session.
  FoxgloveSession(FoxgloveChannels& channels, std::string server, std::string id);
  ~FoxgloveSession() override;

  bool joined() const override { return true; }
  bool take(std::string_view message, bool binary) override;
  LiveMessage next() override;

 private:
  struct Subscription {
    FoxgloveChannel* channel = nullptr;
    ChannelCursor cursor = {};
  };
  using Subscriptions = std::map<std::uint32_t, Subscription>;  ///< by the client's number

  bool reply(StatusLevel level, const std::string& text);
  bool take(const Subscribe& message);
  bool take(const Unsubscribe& message);
  /// The reason why that subscription is not possible; empty if it is.
  std::string objection(const Subscribe::One& one) const;
  std::optional<std::string> next_text();
  std::optional<std::string> next_frame();
  /// The subscription whose next message is the oldest; end() if all have all.
  Subscriptions::iterator earliest(Time& time);
  std::string advertisement();

  FoxgloveChannels& channels_;
  const std::string server_, id_;
  bool greeted_ = false;
  std::deque<std::string> replies_;
  std::size_t notices_ = 0;     ///< number of notices that it has
  std::size_t advertised_ = 0;  ///< number of channels that it knows
  int faults_ = 0;
  Subscriptions subscriptions_;
  std::uint64_t epoch_;
  std::optional<Time> clock_;  ///< time of the last message
};

}  // namespace chasles
