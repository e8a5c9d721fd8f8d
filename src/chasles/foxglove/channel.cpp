#include <algorithm>

#include <nlohmann/json.hpp>

#include <chasles/foxglove/channel.hpp>

namespace chasles {

std::optional<std::string> FoxgloveChannel::encoded(const nlohmann::json& message) const {
  if (message.is_null()) return std::nullopt;
  return proto_bytes(schemas_, topic_.schema, message);
}

StateChannel::StateChannel(ViewerTopic topic, const ProtoSchemas& schemas,
                           const std::vector<RunState>& states, std::function<std::size_t()> ready,
                           Make make)
    : FoxgloveChannel(std::move(topic), schemas),
      states_(states),
      ready_(std::move(ready)),
      make_(std::move(make)) {}

std::size_t StateChannel::index(const ChannelCursor& cursor, std::size_t end) const {
  return std::max(cursor.next, end - std::min(end, kMostBehind));
}

std::optional<Time> StateChannel::due(const ChannelCursor& cursor) const {
  const std::size_t end = ready_();
  if (cursor.next >= end) return std::nullopt;
  return states_[index(cursor, end)].time;
}

std::optional<std::string> StateChannel::take(ChannelCursor& cursor) {
  const std::size_t state = index(cursor, ready_());
  cursor.next = state + 1;
  return encoded(make_(state));
}

void LatestChannel::set(Time time, Make make) {
  ++version_;
  time_ = time;
  make_ = std::move(make);
  made_.reset();
}

std::optional<Time> LatestChannel::due(const ChannelCursor& cursor) const {
  return cursor.next < version_ ? std::optional(time_) : std::nullopt;
}

std::optional<std::string> LatestChannel::take(ChannelCursor& cursor) {
  cursor.next = version_;
  if (!made_) made_ = encoded(make_());
  return *made_;
}

void ListChannel::append(Time time, const nlohmann::json& message) {
  messages_.emplace_back(time, encoded(message).value_or(""));
}

std::optional<Time> ListChannel::due(const ChannelCursor& cursor) const {
  if (cursor.next >= messages_.size()) return std::nullopt;
  return messages_[cursor.next].first;
}

std::optional<std::string> ListChannel::take(ChannelCursor& cursor) {
  return messages_[cursor.next++].second;
}

}  // namespace chasles
