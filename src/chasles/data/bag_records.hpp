#pragma once

#include <cstdint>
#include <cstring>
#include <istream>
#include <map>
#include <string>

#include <fmt/format.h>

namespace chasles {

/// A record of the bag format 2.0: header fields and data.
struct BagRecord {
  std::uint64_t at = 0;  ///< offset of its first byte
  std::map<std::string, std::string> fields = {};
  std::uint8_t op = 0;
  std::uint64_t data = 0;  ///< offset of its first byte
  std::uint32_t size = 0;  ///< size of the data [bytes]
};

/// The source of records: the file, or the bytes of a chunk. A read outside the source throws
/// InputError with the place.
class BagBytes {
 public:
  BagBytes(std::istream& stream, std::uint64_t size, std::string where)
      : stream_(&stream), size_(size), where_(std::move(where)) {}

  std::uint64_t size() const { return size_; }
  const std::string& where() const { return where_; }
  [[noreturn]] void fail(std::uint64_t at, const std::string& what) const;
  std::string bytes(std::uint64_t at, std::uint64_t count) const;
  template <typename Number>
  Number number(std::uint64_t at) const {
    Number value;
    std::memcpy(&value, bytes(at, sizeof value).data(), sizeof value);
    return value;
  }
  BagRecord record(std::uint64_t at) const;
  /// "name=value" entries, each preceded by its length.
  std::map<std::string, std::string> fields(std::uint64_t at, std::uint32_t size) const;

 private:
  std::istream* stream_;
  std::uint64_t size_;
  std::string where_;
};

/// A numeric field of a record. Throws InputError if the field is missing or has another size.
template <typename Number>
Number number_in(const BagBytes& source, const BagRecord& record, const std::string& name) {
  const auto field = record.fields.find(name);
  if (field == record.fields.end() || field->second.size() != sizeof(Number)) {
    source.fail(record.at, fmt::format("field '{}' is missing or of another size", name));
  }
  Number value;
  std::memcpy(&value, field->second.data(), sizeof value);
  return value;
}

}  // namespace chasles
