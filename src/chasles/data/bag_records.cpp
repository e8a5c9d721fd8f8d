#include <chasles/data/bag_records.hpp>
#include <chasles/error.hpp>

namespace chasles {

void BagBytes::fail(std::uint64_t at, const std::string& what) const {
  throw InputError(fmt::format(
      "{}: {} at byte {}: the bag is damaged (rosbag reindex may repair it)", where_, what, at));
}

std::string BagBytes::bytes(std::uint64_t at, std::uint64_t count) const {
  if (at > size_ || count > size_ - at) fail(at, "is truncated, or a length is wrong,");
  std::string bytes(count, '\0');
  stream_->clear();
  stream_->seekg(static_cast<std::streamoff>(at));
  stream_->read(bytes.data(), static_cast<std::streamsize>(count));
  if (!*stream_) fail(at, "cannot be read");
  return bytes;
}

std::map<std::string, std::string> BagBytes::fields(std::uint64_t at, std::uint32_t size) const {
  const std::string header = bytes(at, size);
  std::map<std::string, std::string> result;
  for (std::size_t i = 0; i < header.size();) {
    std::uint32_t length = 0;
    if (header.size() - i < sizeof length) fail(at, "a header is truncated");
    std::memcpy(&length, header.data() + i, sizeof length);
    i += sizeof length;
    if (length > header.size() - i) fail(at, "a header is truncated");
    const std::string field = header.substr(i, length);
    const std::size_t equal = field.find('=');
    if (equal == std::string::npos) fail(at, "a header's field has no value");
    result[field.substr(0, equal)] = field.substr(equal + 1);
    i += length;
  }
  return result;
}

BagRecord BagBytes::record(std::uint64_t at) const {
  BagRecord record{.at = at};
  const auto header = number<std::uint32_t>(at);
  record.fields = fields(at + 4, header);
  record.op = number_in<std::uint8_t>(*this, record, "op");
  record.size = number<std::uint32_t>(at + 4 + header);
  record.data = at + 8 + header;
  if (record.size > size_ - record.data) fail(at, "is truncated, or a length is wrong,");
  return record;
}

}  // namespace chasles
