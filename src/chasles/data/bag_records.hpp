#pragma once

#include <cstdint>
#include <cstring>
#include <istream>
#include <map>
#include <string>

#include <fmt/format.h>

namespace chasles {

/// A record of the format 2.0: a header of fields, and data.
struct BagRecord {
  std::uint64_t at = 0;  ///< where it begins
  std::map<std::string, std::string> fields = {};
  std::uint8_t op = 0;
  std::uint64_t data = 0;  ///< where they begin
  std::uint32_t size = 0;  ///< of the data
};

/// Where records are read from: the file, or the bytes of a chunk. All throw InputError, which
/// names the place, for what lies outside.
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
  /// "name=value" entries, each with its length before it.
  std::map<std::string, std::string> fields(std::uint64_t at, std::uint32_t size) const;

 private:
  std::istream* stream_;
  std::uint64_t size_;
  std::string where_;
};

/// A field of a record that is a number of just that size.
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
