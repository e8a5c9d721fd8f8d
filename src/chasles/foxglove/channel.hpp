#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include <chasles/run_folder/run.hpp>
#include <chasles/viewers/protobuf.hpp>
#include <chasles/viewers/topics.hpp>

namespace chasles {

/// The part of a channel that a subscriber has received. A new one has received nothing.
struct ChannelCursor {
  std::size_t next = 0;  ///< in messages of the channel
  bool truth = false;    ///< /ways: has the true path
};

/// The messages of a topic. They are made when a subscriber can take them, so that a topic without
/// subscribers costs nothing, and nothing is kept for those who are slow.
class FoxgloveChannel {
 public:
  /// The schemas must outlive the channel.
  FoxgloveChannel(ViewerTopic topic, const ProtoSchemas& schemas)
      : topic_(std::move(topic)), schemas_(schemas) {}
  FoxgloveChannel(const FoxgloveChannel&) = delete;
  FoxgloveChannel& operator=(const FoxgloveChannel&) = delete;
  virtual ~FoxgloveChannel() = default;

  const ViewerTopic& topic() const { return topic_; }
  std::string descriptors() const { return file_descriptor_set(schemas_, topic_.schema); }

  /// The time of the next message for a subscriber; none if it has all.
  virtual std::optional<Time> due(const ChannelCursor& cursor) const = 0;
  /// Makes that message, in wire format, and moves the cursor on; none where a state has no
  /// message. Presumes due().
  virtual std::optional<std::string> take(ChannelCursor& cursor) = 0;

  int subscribers = 0;

 protected:
  /// None for null.
  std::optional<std::string> encoded(const nlohmann::json& message) const;

 private:
  const ViewerTopic topic_;
  const ProtoSchemas& schemas_;
};

/// A message for each state. A subscriber gets those of the last kMostBehind states: one that comes
/// late or is slow misses the earlier ones.
class StateChannel final : public FoxgloveChannel {
 public:
  static constexpr std::size_t kMostBehind = 2000;
  using Make = std::function<nlohmann::json(std::size_t state)>;  ///< null: no message

  /// `ready`: the number of states that `make` can be called for, counted from the first.
  StateChannel(ViewerTopic topic, const ProtoSchemas& schemas, const std::vector<RunState>& states,
               std::function<std::size_t()> ready, Make make);

  std::optional<Time> due(const ChannelCursor& cursor) const override;
  std::optional<std::string> take(ChannelCursor& cursor) override;

 private:
  std::size_t index(const ChannelCursor& cursor, std::size_t end) const;

  const std::vector<RunState>& states_;
  const std::function<std::size_t()> ready_;
  const Make make_;
};

/// One message, of which a new one replaces the one before: late subscribers get it, slow ones miss
/// those between.
class LatestChannel final : public FoxgloveChannel {
 public:
  using FoxgloveChannel::FoxgloveChannel;
  using Make = std::function<nlohmann::json()>;  ///< null: no message

  /// `make` is called when a subscriber takes the message, at most once.
  void set(Time time, Make make);

  std::optional<Time> due(const ChannelCursor& cursor) const override;
  std::optional<std::string> take(ChannelCursor& cursor) override;

 private:
  std::size_t version_ = 0;
  Time time_{};
  Make make_;
  std::optional<std::optional<std::string>> made_;
};

/// A list of messages that all subscribers get from its beginning.
class ListChannel final : public FoxgloveChannel {
 public:
  using FoxgloveChannel::FoxgloveChannel;

  std::size_t size() const { return messages_.size(); }
  void append(Time time, const nlohmann::json& message);

  std::optional<Time> due(const ChannelCursor& cursor) const override;
  std::optional<std::string> take(ChannelCursor& cursor) override;

 private:
  std::vector<std::pair<Time, std::string>> messages_;
};

}  // namespace chasles
