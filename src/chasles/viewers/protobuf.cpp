#include <algorithm>
#include <cctype>
#include <cstdint>
#include <cstdlib>
#include <set>
#include <stdexcept>

#include <nlohmann/json.hpp>

#include <chasles/codec/utf8.hpp>
#include <chasles/viewers/byte_sink.hpp>
#include <chasles/viewers/protobuf.hpp>

namespace chasles {
namespace {

using Json = nlohmann::json;

// The wire type of a value: varint, 8 bytes, length and bytes, 4 bytes.
enum class Wire { kVarint = 0, kEight = 1, kBytes = 2, kFour = 5 };

Wire wire(ProtoType type) {
  switch (type) {
    case ProtoType::kDouble:
      return Wire::kEight;
    case ProtoType::kFixed32:
      return Wire::kFour;
    case ProtoType::kInt64:
    case ProtoType::kInt32:
    case ProtoType::kBool:
    case ProtoType::kEnum:
      return Wire::kVarint;
    default:
      return Wire::kBytes;
  }
}

void append_varint(std::string& out, std::uint64_t value) {
  for (; value >= 0x80; value >>= 7) out.push_back(static_cast<char>(value | 0x80));
  out.push_back(static_cast<char>(value));
}

void append_tag(std::string& out, int number, Wire kind) {
  append_varint(out, static_cast<std::uint64_t>(number) << 3 | static_cast<std::uint64_t>(kind));
}

void append_bytes(std::string& out, int number, std::string_view bytes) {
  append_tag(out, number, Wire::kBytes);
  append_varint(out, bytes.size());
  out += bytes;
}

void append_integer(std::string& out, int number, int value) {
  append_tag(out, number, Wire::kVarint);
  append_varint(out, static_cast<std::uint64_t>(value));
}

void append_scalar(std::string& out, ProtoType type, const Json& value) {
  switch (type) {
    case ProtoType::kDouble:
      append_little_endian(out, value.get<double>());
      break;
    case ProtoType::kFixed32:
      append_little_endian(out, value.get<std::uint32_t>());
      break;
    case ProtoType::kBool:
      append_varint(out, value.get<bool>() ? 1 : 0);
      break;
    default:
      append_varint(out, static_cast<std::uint64_t>(value.get<std::int64_t>()));
  }
}

void append_one(std::string& out, const ProtoSchemas& schemas, const ProtoField& field,
                const Json& value) {
  switch (field.type) {
    case ProtoType::kMessage:
      return append_bytes(out, field.number, proto_bytes(schemas, field.of, value));
    case ProtoType::kString:
      return append_bytes(out, field.number, valid_utf8(value.get_ref<const std::string&>()));
    case ProtoType::kBytes: {
      const auto& bytes = value.get_binary();
      return append_bytes(out, field.number,
                          {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
    }
    default:
      append_tag(out, field.number, wire(field.type));
      append_scalar(out, field.type, value);
  }
}

void append_field(std::string& out, const ProtoSchemas& schemas, const ProtoField& field,
                  const Json& value) {
  if (!field.repeated) return append_one(out, schemas, field, value);
  if (wire(field.type) == Wire::kBytes) {
    for (const Json& entry : value) append_one(out, schemas, field, entry);
    return;
  }
  std::string packed;
  for (const Json& entry : value) append_scalar(packed, field.type, entry);
  append_bytes(out, field.number, packed);
}

// "foxglove.Pose" is in foxglove/Pose.proto; Google's files are in small letters.
std::string file_of(std::string name) {
  std::ranges::replace(name, '.', '/');
  if (name.starts_with("google/")) {
    std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  }
  return name + ".proto";
}

std::string field_descriptor(const ProtoField& field) {
  std::string out;
  append_bytes(out, 1, field.name);
  append_integer(out, 3, field.number);
  append_integer(out, 4, field.repeated ? 3 : 1);  // else "optional", which is all of proto3
  append_integer(out, 5, static_cast<int>(field.type));
  if (!field.of.empty()) append_bytes(out, 6, "." + field.of);
  return out;
}

std::string enum_descriptor(const ProtoEnum& enumeration) {
  std::string out;
  append_bytes(out, 1, enumeration.name);
  for (std::size_t i = 0; i < enumeration.values.size(); ++i) {
    std::string value;
    append_bytes(value, 1, enumeration.values[i]);
    append_integer(value, 2, static_cast<int>(i));
    append_bytes(out, 2, value);
  }
  return out;
}

// The messages that the fields refer to, each once.
std::set<std::string> parts(const ProtoMessage& message) {
  std::set<std::string> names;
  for (const ProtoField& field : message.fields) {
    if (field.type == ProtoType::kMessage) names.insert(field.of);
  }
  return names;
}

std::string file_descriptor(const ProtoMessage& message) {
  const std::size_t dot = message.name.rfind('.');
  std::string type, file;
  append_bytes(type, 1, message.name.substr(dot + 1));
  for (const ProtoField& field : message.fields) append_bytes(type, 2, field_descriptor(field));
  for (const ProtoEnum& e : message.enums) append_bytes(type, 4, enum_descriptor(e));
  append_bytes(file, 1, file_of(message.name));
  append_bytes(file, 2, message.name.substr(0, dot));
  for (const std::string& part : parts(message)) append_bytes(file, 3, file_of(part));
  append_bytes(file, 4, type);
  append_bytes(file, 12, "proto3");
  return file;
}

void append_files(std::string& out, const ProtoSchemas& schemas, const std::string& name,
                  std::set<std::string>& done) {
  if (!done.insert(name).second) return;
  const ProtoMessage& message = schemas.at(name);
  for (const std::string& part : parts(message)) append_files(out, schemas, part, done);
  append_bytes(out, 1, file_descriptor(message));
}

ProtoField proto_field(const std::string& message, std::string_view text,
                       const std::vector<ProtoEnum>& enums) {
  static const std::map<std::string, ProtoType, std::less<>> kTypes = {
      {"double", ProtoType::kDouble}, {"int64", ProtoType::kInt64},
      {"int32", ProtoType::kInt32},   {"fixed32", ProtoType::kFixed32},
      {"bool", ProtoType::kBool},     {"string", ProtoType::kString},
      {"bytes", ProtoType::kBytes}};
  ProtoField field;
  const auto word = [&] {
    const std::string_view first = text.substr(0, text.find(' '));
    text.remove_prefix(std::min(text.size(), first.size() + 1));
    return std::string(first);
  };
  std::string type = word();
  field.repeated = type == "repeated";
  if (field.repeated) type = word();
  field.name = word();
  const bool equals = word() == "=";
  field.number = std::atoi(word().c_str());
  const bool known_enum = std::ranges::find(enums, type, &ProtoEnum::name) != enums.end();
  if (const auto built_in = kTypes.find(type); built_in != kTypes.end()) {
    field.type = built_in->second;
  } else {
    field.type = known_enum ? ProtoType::kEnum : ProtoType::kMessage;
    field.of = known_enum ? message + "." + type : type;
  }
  if (equals && field.number > 0 && (field.of.empty() || field.of.find('.') != std::string::npos)) {
    return field;
  }
  throw std::invalid_argument("proto_message: '" + field.name + "' of " + message +
                              " is not a field");
}

}  // namespace

ProtoMessage proto_message(const std::string& name, const std::vector<std::string_view>& fields,
                           std::vector<ProtoEnum> enums) {
  ProtoMessage message{.name = name, .fields = {}, .enums = std::move(enums)};
  for (const std::string_view text : fields) {
    message.fields.push_back(proto_field(name, text, message.enums));
  }
  return message;
}

std::string file_descriptor_set(const ProtoSchemas& schemas, const std::string& name) {
  std::string out;
  std::set<std::string> done;
  append_files(out, schemas, name, done);
  return out;
}

std::string proto_bytes(const ProtoSchemas& schemas, const std::string& name, const Json& value) {
  const std::vector<ProtoField>& fields = schemas.at(name).fields;
  std::string out;
  std::size_t known = 0;
  for (const ProtoField& field : fields) {
    const auto found = value.find(field.name);
    if (found == value.end()) continue;
    append_field(out, schemas, field, *found);
    ++known;
  }
  if (known == value.size()) return out;
  throw std::invalid_argument("proto_bytes: " + value.dump() + " has what " + name + " has not");
}

}  // namespace chasles
