#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json_fwd.hpp>

namespace chasles {

/// Types of fields, by their numbers in Protocol Buffers' own descriptors.
enum class ProtoType {
  kDouble = 1,
  kInt64 = 3,
  kInt32 = 5,
  kFixed32 = 7,
  kBool = 8,
  kString = 9,
  kMessage = 11,
  kBytes = 12,
  kEnum = 14,
};

struct ProtoField {
  std::string name;
  int number = 0;
  ProtoType type = ProtoType::kDouble;
  std::string of;  ///< full name of a kMessage or kEnum: "foxglove.Pose"
  bool repeated = false;
};

/// An enumeration inside of a message; its values count from 0.
struct ProtoEnum {
  std::string name;
  std::vector<std::string> values;
};

/// A message of proto3.
struct ProtoMessage {
  std::string name;  ///< full, "foxglove.Pose"
  std::vector<ProtoField> fields;
  std::vector<ProtoEnum> enums;
};

/// `fields` in the notation of .proto files, "repeated double covariance = 7". A type with a dot is
/// a message; a type without a dot that is not built in is an enumeration of `enums`. Throws
/// std::invalid_argument.
ProtoMessage proto_message(const std::string& name, const std::vector<std::string_view>& fields,
                           std::vector<ProtoEnum> enums = {});

/// Messages by their full names.
using ProtoSchemas = std::map<std::string, ProtoMessage>;

/// The serialised FileDescriptorSet of a message and of all messages that it depends on, one file
/// each, dependencies first.
std::string file_descriptor_set(const ProtoSchemas& schemas, const std::string& name);

/// The wire format of a message. `value` is an object with names of its fields (arrays for repeated
/// fields, binary values for bytes, integers for enumerations). Absent fields are left out, and
/// strings pass through valid_utf8(), as proto3 requires. Throws std::invalid_argument for a name
/// that is not a field.
std::string proto_bytes(const ProtoSchemas& schemas, const std::string& name,
                        const nlohmann::json& value);

}  // namespace chasles
