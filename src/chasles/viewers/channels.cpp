#include <utility>

#include <nlohmann/json.hpp>

#include <chasles/viewers/channels.hpp>

namespace chasles {

Channels::Channels(std::string library, ProtoSchemas schemas) : schemas_(std::move(schemas)) {
  file_.library = std::move(library);
}

void Channels::declare(const ProtoMessage& message) { schemas_.emplace(message.name, message); }

std::size_t Channels::channel(const ViewerTopic& topic) {
  const std::string& schema = topic.schema;
  const auto [number, fresh_schema] = numbers_.try_emplace(schema, file_.schemas.size());
  if (fresh_schema) {
    file_.schemas.push_back(
        {.name = schema, .encoding = "protobuf", .data = file_descriptor_set(schemas_, schema)});
  }
  const auto [channel, fresh] = channels_.try_emplace(topic.topic, file_.channels.size());
  if (fresh) {
    file_.channels.push_back(
        {.topic = topic.topic, .message_encoding = "protobuf", .schema = number->second});
  }
  return channel->second;
}

void Channels::add(const ViewerTopic& topic, Time time, const nlohmann::json& value) {
  file_.messages.push_back({.time = time,
                            .channel = channel(topic),
                            .data = proto_bytes(schemas_, topic.schema, value)});
}

}  // namespace chasles
