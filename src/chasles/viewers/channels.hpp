#pragma once

#include <map>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include <chasles/viewers/mcap_file.hpp>
#include <chasles/viewers/protobuf.hpp>

namespace chasles {

/// Messages on their way into a file: a topic is declared by its first message.
class Channels {
 public:
  Channels(std::string library, ProtoSchemas schemas);

  /// Adds a schema of the house's own.
  void declare(const ProtoMessage& message);

  /// A message of the schema; all of a topic are of one.
  void add(const std::string& topic, const std::string& schema, Time time,
           const nlohmann::json& value);

  const McapFile& file() const { return file_; }

 private:
  std::size_t channel(const std::string& topic, const std::string& schema);

  ProtoSchemas schemas_;
  McapFile file_;
  std::map<std::string, std::size_t> channels_, numbers_;
};

}  // namespace chasles
