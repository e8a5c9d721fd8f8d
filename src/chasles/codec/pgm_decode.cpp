#include <algorithm>

#include <fmt/format.h>

#include <chasles/codec/bytes.hpp>
#include <chasles/codec/image_kinds.hpp>

// Netpbm's grey images: P5 with bytes, P2 with text. The header states the largest value.
namespace chasles {
namespace {

constexpr std::uint32_t kMostPgm = 65535;

bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

/// Reads the numbers of the header, and those of a P2.
class PgmNumbers {
 public:
  PgmNumbers(std::string_view bytes, const std::string& where) : bytes_(bytes), where_(where) {}

  // At most 10^9.
  std::uint32_t next() {
    skip_blanks();
    std::uint32_t value = 0;
    const std::size_t first = at_;
    for (; at_ < bytes_.size() && bytes_[at_] >= '0' && bytes_[at_] <= '9'; ++at_) {
      value = std::min(value * 10 + byte_at(bytes_, at_) - '0', 100'000'000u);
    }
    if (at_ == first)
      damaged_image(where_, "the PGM file is truncated, or has a text for a number");
    return value;
  }
  // What comes after the number and one blank.
  std::string_view rest() const {
    return at_ < bytes_.size() && is_blank(bytes_[at_]) ? bytes_.substr(at_ + 1)
                                                        : std::string_view();
  }

 private:
  void skip_blanks() {
    while (at_ < bytes_.size() && (is_blank(bytes_[at_]) || bytes_[at_] == '#')) {
      if (bytes_[at_] == '#') {
        at_ = std::min(bytes_.find('\n', at_), bytes_.size());
      } else {
        ++at_;
      }
    }
  }

  std::string_view bytes_;
  std::size_t at_ = 2;
  const std::string& where_;
};

struct PgmHeader {
  ImageSize size;
  std::uint32_t most = 255;

  bool deep() const { return most > 255; }
  // A value over the whole range of 8 or 16 bits. Of 10 or 12 bits the lowest become 0, so that the
  // eight highest bits are those of the value.
  std::uint32_t whole_range(std::uint32_t value) const {
    const std::uint32_t all = deep() ? kMostPgm : 255;
    value = std::min(value, most);
    const bool bits = (most & (most + 1)) == 0;
    return bits && deep() ? value * ((all + 1) / (most + 1)) : value * all / most;
  }
};

PgmHeader pgm_header(PgmNumbers& numbers, const std::string& where) {
  const std::uint32_t width = numbers.next(), height = numbers.next(), most = numbers.next();
  if (most < 1 || most > kMostPgm) {
    damaged_image(where, fmt::format("the PGM states {} as its largest value, expected 1 to {}",
                                     most, kMostPgm));
  }
  return {.size = checked_size(width, height, where), .most = most};
}

// Calls value(i) for each pixel, to be brought to the whole range.
template <typename Value>
GreyPixels pgm_pixels(const PgmHeader& header, Value&& value) {
  GreyPixels pixels;
  const std::size_t count = pixel_count(header.size);
  const auto fill = [&](auto& greys) {
    using Grey = typename std::remove_reference_t<decltype(greys)>::value_type;
    greys.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
      greys[i] = static_cast<Grey>(header.whole_range(value(i)));
    }
  };
  if (header.deep()) {
    fill(pixels.deep);
  } else {
    fill(pixels.shallow);
  }
  return pixels;
}

bool is_pgm(std::string_view bytes) {
  return bytes.size() > 2 && bytes[0] == 'P' && (bytes[1] == '5' || bytes[1] == '2') &&
         (is_blank(bytes[2]) || bytes[2] == '#');
}

StatedImage stated_pgm(std::string_view bytes, const std::string& where) {
  PgmNumbers numbers(bytes, where);
  const PgmHeader header = pgm_header(numbers, where);
  return {.size = header.size, .deep = header.deep()};
}

GreyPixels decode_pgm(std::string_view bytes, const std::string& where) {
  PgmNumbers numbers(bytes, where);
  const PgmHeader header = pgm_header(numbers, where);
  const std::string_view data = numbers.rest();
  const bool text = bytes[1] == '2';
  // A number of a P2 takes two bytes, but for the last.
  const std::size_t each = text || header.deep() ? 2 : 1;
  if (data.size() + (text ? 1 : 0) < pixel_count(header.size) * each) {
    damaged_image(where, "the PGM file is truncated");
  }
  if (text) return pgm_pixels(header, [&](std::size_t) { return numbers.next(); });
  if (!header.deep()) return pgm_pixels(header, [&](std::size_t i) { return byte_at(data, i); });
  return pgm_pixels(
      header, [&](std::size_t i) { return byte_at(data, 2 * i) << 8 | byte_at(data, 2 * i + 1); });
}

}  // namespace

ImageKind pgm_kind() {
  return {.name = "PGM", .is = is_pgm, .stated = stated_pgm, .decode = decode_pgm};
}

}  // namespace chasles
