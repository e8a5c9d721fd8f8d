#include <algorithm>
#include <limits>
#include <optional>
#include <zlib.h>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/bytes.hpp>
#include <chasles/codec/mat_structure.hpp>
#include <chasles/codec/read_budget.hpp>

namespace chasles {
namespace {

constexpr std::size_t kMatHeader = 128, kMatTag = 8;
constexpr std::size_t kBytesOfMember = 400;  // of libmatio, for a cell or a field of a struct
constexpr std::size_t kLongestArrayHead = 1024;
constexpr std::size_t kLongestName = 256, kMostDimensions = 32;

enum MatType : std::size_t { kText = 1, kInt32 = 5, kUint32 = 6, kArray = 14, kCompressed = 15 };
enum MatClass : std::size_t { kCell = 1, kStruct = 2, kObject = 3, kFunction = 16 };

struct MatElement {
  std::size_t type = 0;
  std::string_view data;
  bool within = false;  // the tag
};

// The data elements of a file: a tag (type, size) and the data, padded to eight bytes. Up to four
// bytes are within the tag.
class MatElements {
 public:
  MatElements(std::string_view bytes, bool big_endian) : rest_(bytes), big_endian_(big_endian) {}

  std::size_t number(std::string_view bytes, std::size_t at) const {
    std::size_t value = 0;
    for (std::size_t i = 0; i < 4; ++i)
      value = value << 8 | byte_at(bytes, at + (big_endian_ ? i : 3 - i));
    return value;
  }

  // None for an element that is longer than the bytes.
  std::optional<MatElement> next() {
    if (rest_.size() < kMatTag) return std::nullopt;
    const std::size_t tag = number(rest_, 0);
    const bool within = tag >> 16 != 0;
    const std::size_t size = within ? tag >> 16 : number(rest_, 4);
    if (within ? size > 4 : size > rest_.size() - kMatTag) return std::nullopt;
    const MatElement element{.type = within ? tag & 0xffff : tag,
                             .data = rest_.substr(within ? 4 : kMatTag, size),
                             .within = within};
    const std::size_t padded = within ? 0 : (size + 7) / 8 * 8;
    rest_.remove_prefix(std::min(rest_.size(), kMatTag + padded));
    return element;
  }

  std::size_t left() const { return rest_.size(); }

 private:
  std::string_view rest_;
  bool big_endian_;
};

// The product, or the largest number.
std::size_t times(std::size_t a, std::size_t b) {
  constexpr std::size_t kMost = std::numeric_limits<std::size_t>::max();
  return b != 0 && a > kMost / b ? kMost : a * b;
}

class MatArrays {
 public:
  MatArrays(bool big_endian, const std::string& file) : big_endian_(big_endian), file_(file) {}

  // Whether the data of an array are one. `bytes` may end early if it has no members.
  bool is_array(std::string_view bytes, int depth) {
    if (bytes.empty()) return true;
    check_depth(file_, depth);
    MatElements elements(bytes, big_endian_);
    const auto flags = elements.next(), sizes = elements.next(), name = elements.next();
    if (!flags || flags->type != kUint32 || flags->data.size() != 8) return false;
    if (!sizes || sizes->type != kInt32 || sizes->data.size() % 4 != 0) return false;
    if (sizes->data.size() < 8 || sizes->data.size() > 4 * kMostDimensions) return false;
    if (!name || name->type != kText || name->data.size() > kLongestName) return false;
    std::size_t members = 1;
    for (std::size_t at = 0; at < sizes->data.size(); at += 4) {
      members = times(members, elements.number(sizes->data, at));
    }
    switch (elements.number(flags->data, 0) & 0xff) {
      case kStruct:
      case kObject:
        return has_members(elements, members, true, depth);
      case kCell:
      case kFunction:
        return has_members(elements, members, false, depth);
      default:
        return true;
    }
  }

  // The same for the content of a compressed element, whose first bytes give its kind.
  bool is_compressed_array(std::string_view deflated) {
    const std::string head = inflated(deflated, kLongestArrayHead);
    if (head.size() < kMatTag) return false;
    MatElements tag(head, big_endian_);
    const std::size_t size = tag.number(head, 4);
    if (tag.number(head, 0) != kArray || size / kMostInflation > deflated.size()) return false;
    const std::string_view data = std::string_view(head).substr(kMatTag, size);
    if (!may_have_members(data)) return is_array(data, 1);
    check_memory(
        fmt::format("{}: claims {} bytes from {} compressed ones", file_, size, deflated.size()),
        size);
    const std::string all = inflated(deflated, kMatTag + size);
    return all.size() == kMatTag + size && is_array(std::string_view(all).substr(kMatTag), 1);
  }

 private:
  bool may_have_members(std::string_view array) const {
    if (array.size() < kMatTag + 4) return false;
    const std::size_t kind = MatElements(array, big_endian_).number(array, kMatTag) & 0xff;
    return kind == kCell || kind == kStruct || kind == kObject || kind == kFunction;
  }

  // `count`: the number of cells, or of structs, which have the fields that are named first.
  bool has_members(MatElements& elements, std::size_t count, bool fields, int depth) {
    if (fields) {
      auto length = elements.next();
      if (length && length->type == kText) length = elements.next();  // after the name of a class
      const auto names = elements.next();
      if (!length || length->type != kInt32 || length->data.size() != 4 || !names) return false;
      // libmatio knows these two forms only, and would take other bytes for the sizes.
      if (!length->within || names->within) return false;
      const std::size_t each = elements.number(length->data, 0);
      if (each == 0 && !names->data.empty()) return false;
      count = times(count, each == 0 ? 0 : names->data.size() / each);
    }
    if (count > elements.left() / kMatTag) return false;
    members_ += count;
    check_memory(fmt::format("{}: has more than {} cells or fields", file_, members_ - 1),
                 members_ * kBytesOfMember);
    for (; count > 0; --count) {
      const auto member = elements.next();
      if (!member || member->type != kArray || !is_array(member->data, depth + 1)) return false;
    }
    return true;
  }

  // At most `most` bytes; fewer if the data end or are damaged.
  static std::string inflated(std::string_view deflated, std::size_t most) {
    std::string bytes(most, '\0');
    z_stream stream{};
    if (inflateInit(&stream) != Z_OK) return {};
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(deflated.data()));
    stream.avail_in = static_cast<uInt>(deflated.size());
    stream.next_out = reinterpret_cast<Bytef*>(bytes.data());
    stream.avail_out = static_cast<uInt>(most);
    inflate(&stream, Z_SYNC_FLUSH);
    bytes.resize(most - stream.avail_out);
    inflateEnd(&stream);
    return bytes;
  }

  bool big_endian_;
  const std::string& file_;
  std::size_t members_ = 0;
};

}  // namespace

void check_mat_structure(std::string_view bytes, bool big_endian, const std::string& file) {
  MatArrays arrays(big_endian, file);
  std::size_t position = kMatHeader;
  while (position + kMatTag <= bytes.size()) {
    const MatElements tag(bytes.substr(position), big_endian);
    const std::size_t type = tag.number(bytes, position), size = tag.number(bytes, position + 4);
    const std::string_view data = bytes.substr(position + kMatTag, size);
    const bool sound = type == kArray        ? data.size() < size || arrays.is_array(data, 1)
                       : type == kCompressed ? arrays.is_compressed_array(data)
                                             : true;
    if (!sound) {
      throw InputError(fmt::format(
          "{}: the header of the array at byte {} is not one: the file is damaged, copy it again",
          file, position));
    }
    position += kMatTag + size;
  }
  if (position == bytes.size()) return;
  throw InputError(
      fmt::format("{}: ends within a variable: it has {} bytes, expected {} or more; the file is "
                  "truncated or damaged",
                  file, bytes.size(), position));
}

}  // namespace chasles
