#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/video/gpmf.hpp>

namespace chasles {
namespace {

constexpr std::size_t kItemHeader = 8, kAlignment = 4;

std::uint64_t big_endian(std::string_view bytes) {
  std::uint64_t value = 0;
  for (const char c : bytes) value = value << 8 | static_cast<unsigned char>(c);
  return value;
}

// Two's complement of so many bytes.
double signed_of(std::uint64_t value, std::size_t bytes) {
  const auto bits = static_cast<int>(8 * bytes);
  return static_cast<double>(static_cast<std::int64_t>(value << (64 - bits)) >> (64 - bits));
}

// The bytes of a number of a type; none for types of other things.
std::optional<std::size_t> size_of_type(char type) {
  switch (type) {
    case 'b':
    case 'B':
      return 1;
    case 's':
    case 'S':
      return 2;
    case 'l':
    case 'L':
    case 'f':
    case 'q':
      return 4;
    case 'j':
    case 'J':
    case 'd':
    case 'Q':
      return 8;
    default:
      return std::nullopt;
  }
}

double number_of(char type, std::string_view bytes) {
  const std::uint64_t raw = big_endian(bytes);
  switch (type) {
    case 'f':
      return static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(raw)));
    case 'd':
      return std::bit_cast<double>(raw);
    case 'q':  // 16 bits before the point, 16 behind it
      return signed_of(raw, 4) / 65536.0;
    case 'Q':
      return signed_of(raw, 8) / 4294967296.0;
    case 'B':
    case 'S':
    case 'L':
    case 'J':
      return static_cast<double>(raw);
    default:
      return signed_of(raw, bytes.size());
  }
}

[[noreturn]] void fail_item(const std::string& where, const GpmfItem& item,
                            const std::string& what) {
  // Damaged letters may be anything.
  std::string letters = item.key + item.type;
  for (char& c : letters) c = c >= ' ' && c <= '~' ? c : '?';
  throw InputError(fmt::format("{}: {} of {} samples of {} bytes, type '{}': {}", where,
                               letters.substr(0, 4), item.repeat, item.size, letters.substr(4),
                               what));
}

// Divides the channels by the scale that the stream states: one for all, or one each.
void divide(std::vector<double>& sample, const std::vector<double>& scale) {
  for (std::size_t i = 0; i < sample.size(); ++i) {
    if (!scale.empty()) sample[i] /= scale.size() == 1 ? scale[0] : scale[i];
  }
}

std::vector<double> scale_of(const GpmfItem& item, const std::string& where) {
  std::vector<double> scale = gpmf_numbers(item, where);
  if (scale.empty() || std::ranges::any_of(scale, [](double s) { return s == 0; })) {
    fail_item(where, item, "expected divisors other than 0");
  }
  return scale;
}

std::vector<std::vector<double>> samples_of(const GpmfItem& item, const std::vector<double>& scale,
                                            const std::string& where) {
  const std::vector<double> numbers = gpmf_numbers(item, where);
  const std::size_t channels = item.repeat == 0 ? 0 : numbers.size() / item.repeat;
  if (scale.size() > 1 && item.repeat > 0 && scale.size() != channels) {
    fail_item(where, item, fmt::format("expected {} channels, one for each SCAL", scale.size()));
  }
  std::vector<std::vector<double>> samples;
  for (std::size_t i = 0; i < item.repeat; ++i) {
    const auto first = numbers.begin() + static_cast<std::ptrdiff_t>(i * channels);
    divide(samples.emplace_back(first, first + static_cast<std::ptrdiff_t>(channels)), scale);
  }
  return samples;
}

// The samples are the last item of a stream: those before state what holds for them.
GpmfSamples stream_of_items(const std::vector<GpmfItem>& items, const std::string& device,
                            const std::vector<std::string>& wanted, const std::string& where) {
  GpmfSamples stream{.key = items.back().key, .device = device};
  std::vector<double> scale;
  for (const GpmfItem& item : items) {
    if (item.key == "STMP") stream.stamp = gpmf_count(item, where);
    if (item.key == "TSMP") stream.total = gpmf_count(item, where);
    if (item.key == "SCAL") scale = scale_of(item, where);
    if (item.key == "SIUN" || item.key == "UNIT") stream.unit = gpmf_text(item);
    if (item.key == "STNM") stream.name = gpmf_text(item);
    if (item.key == "ORIN") stream.axes_in = gpmf_text(item);
    if (item.key == "ORIO") stream.axes_out = gpmf_text(item);
    if (item.key == "MTRX") stream.matrix = gpmf_numbers(item, where);
    if (item.key == "TIMO") {
      const std::vector<double> delay = gpmf_numbers(item, where);
      if (delay.size() != 1 || !std::isfinite(delay[0])) fail_item(where, item, "expected seconds");
      stream.delay = delay[0];
    }
  }
  stream.count = items.back().repeat;
  if (std::ranges::find(wanted, stream.key) != wanted.end()) {
    stream.samples = samples_of(items.back(), scale, where);
  }
  return stream;
}

}  // namespace

std::vector<GpmfItem> gpmf_items(std::string_view bytes, const std::string& where) {
  std::vector<GpmfItem> items;
  while (bytes.size() >= kItemHeader) {
    GpmfItem item{.key = std::string(bytes.substr(0, 4)),
                  .type = bytes[4],
                  .size = static_cast<unsigned char>(bytes[5]),
                  .repeat = static_cast<std::size_t>(big_endian(bytes.substr(6, 2))),
                  .data = {}};
    if (item.key == std::string(4, '\0')) break;
    const std::size_t length = item.size * item.repeat;
    bytes.remove_prefix(kItemHeader);
    if (length > bytes.size()) {
      fail_item(where, item, fmt::format("only {} bytes follow", bytes.size()));
    }
    item.data = bytes.substr(0, length);
    bytes.remove_prefix(
        std::min(bytes.size(), (length + kAlignment - 1) / kAlignment * kAlignment));
    items.push_back(std::move(item));
  }
  return items;
}

std::vector<double> gpmf_numbers(const GpmfItem& item, const std::string& where) {
  const auto size = size_of_type(item.type);
  if (!size || item.size % *size != 0) fail_item(where, item, "expected numbers");
  std::vector<double> numbers;
  numbers.reserve(item.data.size() / *size);
  for (std::size_t at = 0; at < item.data.size(); at += *size) {
    numbers.push_back(number_of(item.type, item.data.substr(at, *size)));
  }
  return numbers;
}

std::uint64_t gpmf_count(const GpmfItem& item, const std::string& where) {
  const bool is_count = item.type == 'J' || item.type == 'L' || item.type == 'S';
  if (!is_count || item.data.size() != size_of_type(item.type)) {
    fail_item(where, item, "expected one whole number");
  }
  return big_endian(item.data);
}

std::string gpmf_text(const GpmfItem& item) {
  std::string text(item.data);
  const std::size_t last = text.find_last_not_of(std::string_view("\0 ", 2));
  text.resize(last + 1);  // npos + 1 is 0
  std::ranges::replace(text, '\xb2', '2');
  std::ranges::replace(text, '\xb3', '3');
  return text;
}

std::vector<GpmfSamples> gpmf_streams(std::string_view payload,
                                      const std::vector<std::string>& wanted,
                                      const std::string& where) {
  std::vector<GpmfSamples> streams;
  for (const GpmfItem& device : gpmf_items(payload, where)) {
    if (device.key != "DEVC" || !device.is_nest()) continue;
    std::string name;
    for (const GpmfItem& item : gpmf_items(device.data, where)) {
      if (item.key == "DVID" && item.type == 'L') name = fmt::format("{}", gpmf_count(item, where));
      if (item.key == "DVNM")
        name = fmt::format("{}{}{}", name, name.empty() ? "" : " ", gpmf_text(item));
      if (item.key != "STRM" || !item.is_nest()) continue;
      const std::vector<GpmfItem> items = gpmf_items(item.data, where);
      if (!items.empty()) streams.push_back(stream_of_items(items, name, wanted, where));
    }
  }
  return streams;
}

}  // namespace chasles
