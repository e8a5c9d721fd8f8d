#pragma once

#include <map>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include <chasles/viewers/mcap_file.hpp>
#include <chasles/viewers/protobuf.hpp>
#include <chasles/viewers/topics.hpp>

namespace chasles {

/// Collects messages for a file. The first message of a topic declares the topic.
class Channels {
 public:
  Channels(std::string library, ProtoSchemas schemas);

  /// Adds a schema specific to Chasles.
  void declare(const ProtoMessage& message);

  /// Adds a message. All messages of a topic have the same schema.
  void add(const ViewerTopic& topic, Time time, const nlohmann::json& value);

  const McapFile& file() const { return file_; }

 private:
  std::size_t channel(const ViewerTopic& topic);

  ProtoSchemas schemas_;
  McapFile file_;
  std::map<std::string, std::size_t> channels_, numbers_;
};

}  // namespace chasles
