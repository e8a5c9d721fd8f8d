#include <array>
#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/bytes.hpp>
#include <chasles/codec/npy.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {
namespace {

static_assert(std::endian::native == std::endian::little, "the bytes are taken as they are");

constexpr std::string_view kMagic = "\x93NUMPY";
constexpr std::size_t kLongestText = 65536;

struct NamedType {
  std::string_view name;
  NpyType type;
  std::size_t size;
};
constexpr std::array<NamedType, 10> kTypes{{{"f8", NpyType::kFloat64, 8},
                                            {"f4", NpyType::kFloat32, 4},
                                            {"i1", NpyType::kInt8, 1},
                                            {"i2", NpyType::kInt16, 2},
                                            {"i4", NpyType::kInt32, 4},
                                            {"i8", NpyType::kInt64, 8},
                                            {"u1", NpyType::kUint8, 1},
                                            {"u2", NpyType::kUint16, 2},
                                            {"u4", NpyType::kUint32, 4},
                                            {"u8", NpyType::kUint64, 8}}};

[[noreturn]] void fail(const std::string& where, std::string_view what) {
  throw InputError(fmt::format("{}: the .npy header {}", where, what));
}

NpyType type_named(std::string_view descr, const std::string& where) {
  const bool native = descr.size() > 1 && std::string_view("<|=").find(descr[0]) != descr.npos;
  for (const NamedType& known : kTypes) {
    if (native && descr.substr(1) == known.name) return known.type;
  }
  throw InputError(fmt::format(
      "{}: has dtype '{}', expected little-endian real numbers ('<f8', '<f4' or integers)", where,
      descr));
}

// Parser of the header text, a Python dictionary.
class DictParser {
 public:
  DictParser(std::string_view text, const std::string& where) : text_(text), where_(where) {}

  NpyHeader parse() {
    NpyHeader header;
    int found = 0;
    expect('{');
    while (!take('}')) {
      const std::string_view key = string();
      expect(':');
      if (key == "descr") {
        if (peek() == '[') fail(where_, "describes records, expected plain numbers");
        header.type = type_named(string(), where_);
        found |= 1;
      } else if (key == "fortran_order") {
        header.fortran_order = boolean();
        found |= 2;
      } else if (key == "shape") {
        header.shape = tuple();
        found |= 4;
      } else {
        fail(where_, fmt::format("has the unknown key '{}'", key));
      }
      take(',');
    }
    if (found != 7) fail(where_, "lacks one of 'descr', 'fortran_order', 'shape'");
    return header;
  }

 private:
  char peek() {
    text_ = trimmed(text_);
    return text_.empty() ? '\0' : text_.front();
  }
  bool take(char c) {
    if (peek() != c) return false;
    text_.remove_prefix(1);
    return true;
  }
  void expect(char c) {
    if (!take(c))
      fail(where_, fmt::format("is malformed: expected '{}' before '{:.20}'", c, text_));
  }
  std::string_view string() {
    const char quote = peek() == '"' ? '"' : '\'';
    expect(quote);
    const std::size_t end = text_.find(quote);
    if (end == std::string_view::npos) fail(where_, "is malformed: a string does not end");
    const std::string_view result = text_.substr(0, end);
    text_.remove_prefix(end + 1);
    return result;
  }
  bool boolean() {
    peek();
    for (const std::string_view word : {std::string_view("True"), std::string_view("False")}) {
      if (!text_.starts_with(word)) continue;
      text_.remove_prefix(word.size());
      return word == "True";
    }
    fail(where_, "is malformed: expected True or False");
  }
  std::vector<std::size_t> tuple() {
    std::vector<std::size_t> result;
    expect('(');
    while (!take(')')) {
      peek();
      std::uint64_t value = 0;
      const auto [end, error] = std::from_chars(text_.data(), text_.data() + text_.size(), value);
      if (error != std::errc()) fail(where_, "is malformed: expected a size in the shape");
      text_.remove_prefix(static_cast<std::size_t>(end - text_.data()));
      result.push_back(value);
      if (result.size() > 32) fail(where_, "has more than 32 dimensions");
      take('L');
      take(',');
    }
    return result;
  }

  std::string_view text_;
  const std::string& where_;
};

template <typename T>
void convert(std::string_view bytes, double* values) {
  for (std::size_t i = 0; i * sizeof(T) < bytes.size(); ++i) {
    T value;
    std::memcpy(&value, bytes.data() + i * sizeof(T), sizeof(T));
    values[i] = static_cast<double>(value);
  }
}

std::size_t text_begin(std::string_view preamble) { return preamble[6] == 1 ? 10 : 12; }

}  // namespace

std::size_t npy_size(NpyType type) {
  for (const NamedType& known : kTypes) {
    if (known.type == type) return known.size;
  }
  return 8;
}

std::size_t npy_header_size(std::string_view preamble, const std::string& where) {
  if (preamble.size() < kNpyPreamble || !preamble.starts_with(kMagic)) {
    throw InputError(where + ": is not an .npy array (its first bytes are not '\\x93NUMPY')");
  }
  if (preamble[6] < 1 || preamble[6] > 3) {
    fail(where, fmt::format("has version {}.{}, expected 1.0, 2.0 or 3.0", byte_at(preamble, 6),
                            byte_at(preamble, 7)));
  }
  std::size_t length = byte_at(preamble, 8) | byte_at(preamble, 9) << 8;
  if (preamble[6] > 1) length |= byte_at(preamble, 10) << 16 | byte_at(preamble, 11) << 24;
  if (length > kLongestText) {
    fail(where, fmt::format("claims {} bytes, expected at most {}", length, kLongestText));
  }
  return text_begin(preamble) + length;
}

NpyHeader parse_npy_header(std::string_view header, const std::string& where) {
  std::string_view text = header.substr(text_begin(header));
  while (!text.empty() && (text.back() == '\n' || text.back() == '\0')) text.remove_suffix(1);
  NpyHeader result = DictParser(text, where).parse();
  for (const std::size_t size : result.shape) {
    if (size != 0 && result.count > std::numeric_limits<std::uint32_t>::max() / size) {
      fail(where, "claims more than 2^32 numbers");
    }
    result.count *= size;
  }
  return result;
}

void npy_to_double(NpyType type, std::string_view bytes, double* values) {
  switch (type) {
    case NpyType::kFloat64:
      std::memcpy(values, bytes.data(), bytes.size());
      return;
    case NpyType::kFloat32:
      return convert<float>(bytes, values);
    case NpyType::kInt8:
      return convert<std::int8_t>(bytes, values);
    case NpyType::kInt16:
      return convert<std::int16_t>(bytes, values);
    case NpyType::kInt32:
      return convert<std::int32_t>(bytes, values);
    case NpyType::kInt64:
      return convert<std::int64_t>(bytes, values);
    case NpyType::kUint8:
      return convert<std::uint8_t>(bytes, values);
    case NpyType::kUint16:
      return convert<std::uint16_t>(bytes, values);
    case NpyType::kUint32:
      return convert<std::uint32_t>(bytes, values);
    case NpyType::kUint64:
      return convert<std::uint64_t>(bytes, values);
  }
}

}  // namespace chasles
