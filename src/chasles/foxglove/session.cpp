#include <algorithm>
#include <memory>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include <chasles/foxglove/protocol.hpp>
#include <chasles/foxglove/session.hpp>

namespace chasles {
namespace {

// The client's number of a channel is its index, from 1 on.
std::uint32_t channel_id(std::size_t index) { return static_cast<std::uint32_t>(index + 1); }

LiveMessage message_of(std::string bytes, bool binary) {
  return {.bytes = std::make_shared<const std::string>(std::move(bytes)), .binary = binary};
}

}  // namespace

FoxgloveSession::FoxgloveSession(FoxgloveChannels& channels, std::string server, std::string id)
    : channels_(channels),
      server_(std::move(server)),
      id_(std::move(id)),
      epoch_(channels.epoch()) {}

FoxgloveSession::~FoxgloveSession() {
  for (const auto& [id, subscription] : subscriptions_) --subscription.channel->subscribers;
}

bool FoxgloveSession::reply(StatusLevel level, const std::string& text) {
  if (replies_.size() < kMostReplies) replies_.push_back(status_text(level, text));
  return ++faults_ <= kMostFaults;
}

bool FoxgloveSession::take(std::string_view message, bool binary) {
  const ClientMessage parsed = parse_client_message(message, binary);
  if (const auto* fault = std::get_if<ClientFault>(&parsed)) {
    return reply(StatusLevel::kError, fault->why);
  }
  if (const auto* subscribe = std::get_if<Subscribe>(&parsed)) return take(*subscribe);
  return take(std::get<Unsubscribe>(parsed));
}

std::string FoxgloveSession::objection(const Subscribe::One& one) const {
  const auto& channels = channels_.channels();
  if (one.channel < 1 || one.channel > channels.size()) {
    return fmt::format("subscribe: there is no channel {}", one.channel);
  }
  if (subscriptions_.contains(one.id)) {
    return fmt::format("subscribe: subscription {} exists already", one.id);
  }
  const FoxgloveChannel* channel = channels[one.channel - 1].get();
  const auto is_it = [&](const auto& entry) { return entry.second.channel == channel; };
  if (std::ranges::any_of(subscriptions_, is_it)) {
    return fmt::format("subscribe: channel {} has a subscription already", one.channel);
  }
  return "";
}

bool FoxgloveSession::take(const Subscribe& message) {
  for (const Subscribe::One& one : message.subscriptions) {
    if (const std::string why = objection(one); !why.empty()) {
      if (!reply(StatusLevel::kError, why)) return false;
      continue;
    }
    FoxgloveChannel* channel = channels_.channels()[one.channel - 1].get();
    ++channel->subscribers;
    subscriptions_[one.id] = {.channel = channel};
  }
  return true;
}

bool FoxgloveSession::take(const Unsubscribe& message) {
  for (const std::uint32_t id : message.ids) {
    const auto found = subscriptions_.find(id);
    if (found == subscriptions_.end()) {
      const std::string why = fmt::format("unsubscribe: there is no subscription {}", id);
      if (!reply(StatusLevel::kWarning, why)) return false;
      continue;
    }
    --found->second.channel->subscribers;
    subscriptions_.erase(found);
  }
  return true;
}

LiveMessage FoxgloveSession::next() {
  if (std::optional<std::string> text = next_text()) return message_of(std::move(*text), false);
  if (std::optional<std::string> frame = next_frame()) return message_of(std::move(*frame), true);
  return {};
}

std::optional<std::string> FoxgloveSession::next_text() {
  if (!std::exchange(greeted_, true)) return server_info_text(server_, id_);
  if (!replies_.empty()) {
    std::string reply = std::move(replies_.front());
    replies_.pop_front();
    return reply;
  }
  if (advertised_ < channels_.channels().size()) return advertisement();
  if (notices_ < channels_.notices().size()) {
    const FoxgloveChannels::Notice& notice = channels_.notices()[notices_++];
    return status_text(notice.level, notice.text);
  }
  return std::nullopt;
}

std::string FoxgloveSession::advertisement() {
  const auto& channels = channels_.channels();
  std::vector<AdvertisedChannel> list;
  for (; advertised_ < channels.size(); ++advertised_) {
    const FoxgloveChannel& channel = *channels[advertised_];
    list.push_back({.id = channel_id(advertised_),
                    .topic = channel.topic(),
                    .descriptors = channel.descriptors()});
  }
  return advertise_text(list);
}

FoxgloveSession::Subscriptions::iterator FoxgloveSession::earliest(Time& time) {
  auto found = subscriptions_.end();
  for (auto it = subscriptions_.begin(); it != subscriptions_.end(); ++it) {
    const std::optional<Time> due = it->second.channel->due(it->second.cursor);
    if (!due || (found != subscriptions_.end() && *due >= time)) continue;
    found = it;
    time = *due;
  }
  return found;
}

std::optional<std::string> FoxgloveSession::next_frame() {
  if (std::exchange(epoch_, channels_.epoch()) != channels_.epoch()) {
    for (auto& [id, subscription] : subscriptions_) subscription.cursor = {};
    clock_.reset();
  }
  while (true) {
    Time time = channels_.now().value_or(Time::min());
    const auto found = earliest(time);
    if (time != Time::min() && (!clock_ || time > *clock_)) {
      clock_ = time;
      return time_frame(time);
    }
    if (found == subscriptions_.end()) return std::nullopt;
    Subscription& subscription = found->second;
    const std::optional<std::string> data = subscription.channel->take(subscription.cursor);
    if (data) return message_frame(found->first, time, *data);
  }
}

}  // namespace chasles
