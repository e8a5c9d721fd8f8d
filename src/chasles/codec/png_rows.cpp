#include <algorithm>
#include <bit>
#include <cstring>
#include <vector>

#include <chasles/codec/png_rows.hpp>

// A pixel's prediction needs the decoded pixel to its left, and of the row above the pixel at the
// same place and its left neighbour. Along a row each pixel waits for the one before it. Here eight
// rows are decoded at once, each one pixel behind the row above it: they form the lanes of a
// vector. The vectors are those of GCC and Clang, which every processor has or the compiler
// replaces; all arithmetic is in integers.
namespace chasles {
namespace {

constexpr std::size_t kLanes = 8;  // rows at a time

using Lanes = std::int16_t __attribute__((vector_size(16)));
using Bytes = std::uint8_t __attribute__((vector_size(16)));
using Words = std::uint64_t __attribute__((vector_size(16)));

enum PngFilter : std::uint8_t { kPlain, kLeft, kAbove, kMean, kPaeth, kFilters };

Bytes zip_low(Bytes a, Bytes b) {
  return __builtin_shufflevector(a, b, 0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
}
Bytes zip_high(Bytes a, Bytes b) {
  return __builtin_shufflevector(a, b, 8, 24, 9, 25, 10, 26, 11, 27, 12, 28, 13, 29, 14, 30, 15,
                                 31);
}

// The first or the last eight bytes, one in each lane; and back, of lanes from 0 to 255.
constexpr bool kLittle = std::endian::native == std::endian::little;
Lanes low_lanes(Bytes bytes) {
  return reinterpret_cast<Lanes>(kLittle ? zip_low(bytes, Bytes{}) : zip_low(Bytes{}, bytes));
}
Lanes high_lanes(Bytes bytes) {
  return reinterpret_cast<Lanes>(kLittle ? zip_high(bytes, Bytes{}) : zip_high(Bytes{}, bytes));
}
Bytes bytes_of(Lanes low, Lanes high) {
  const auto a = reinterpret_cast<Bytes>(low), b = reinterpret_cast<Bytes>(high);
  if constexpr (kLittle) {
    return __builtin_shufflevector(a, b, 0, 2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24, 26, 28, 30);
  } else {
    return __builtin_shufflevector(a, b, 1, 3, 5, 7, 9, 11, 13, 15, 17, 19, 21, 23, 25, 27, 29, 31);
  }
}

// Each lane gets what the one before it has, the first 0.
Lanes one_lane_on(Lanes x) {
  return __builtin_shufflevector(Lanes{}, x, 0, 8, 9, 10, 11, 12, 13, 14);
}

// Transposes 8 x 8 bytes: shuffling the halves of 64 bytes into each other moves each number's bits
// by one, and after three times columns and rows have changed places.
struct Square {
  Bytes part[4];

  void transpose() {
    for (int i = 0; i < 3; ++i) {
      *this = {{zip_low(part[0], part[2]), zip_high(part[0], part[2]), zip_low(part[1], part[3]),
                zip_high(part[1], part[3])}};
    }
  }
};

Lanes magnitude(Lanes x) {
  const Lanes sign = x >> 15;
  return (x ^ sign) - sign;
}

Lanes choose(Lanes mask, Lanes yes, Lanes no) { return (mask & yes) | (~mask & no); }

Lanes paeth(Lanes left, Lanes above, Lanes corner) {
  const Lanes to_left = above - corner, to_above = left - corner;
  const Lanes far_left = magnitude(to_left), far_above = magnitude(to_above),
              far_corner = magnitude(to_left + to_above);
  const Lanes other = choose(far_above <= far_corner, above, corner);
  return choose((far_left <= far_above) & (far_left <= far_corner), left, other);
}

// Which lanes have which filter: all bits or none.
struct Filters {
  Lanes left{}, above{}, mean{}, paeth{};
  bool only_paeth = true;

  void set(std::size_t lane, std::uint8_t filter) {
    left[lane] = filter == kLeft ? -1 : 0;
    above[lane] = filter == kAbove ? -1 : 0;
    mean[lane] = filter == kMean ? -1 : 0;
    paeth[lane] = filter == kPaeth ? -1 : 0;
    only_paeth = only_paeth && filter == kPaeth;
  }
};

template <bool kOnlyPaeth>
Lanes predicted(const Filters& filters, Lanes left, Lanes above, Lanes corner) {
  const Lanes slope = paeth(left, above, corner);
  if constexpr (kOnlyPaeth) return slope;
  return (filters.paeth & slope) | (filters.left & left) | (filters.above & above) |
         (filters.mean & ((left + above) >> 1));
}

// Rows between margins, because the lanes begin and end at different times. What is left of a row
// is zero, and stays zero. What is right of it is never used by a pixel of the row.
class RowGroup {
 public:
  RowGroup(std::size_t row_bytes, std::size_t pixel_bytes)
      : row_bytes_(row_bytes),
        pixel_bytes_(pixel_bytes),
        margin_((kLanes - 1) * pixel_bytes),
        stride_(margin_ + row_bytes + margin_ + kLanes),
        rows_(stride_ * kLanes),
        above_(stride_) {}

  std::uint8_t* row(std::size_t lane) { return rows_.data() + lane * stride_ + margin_; }

  void decode(const Filters& filters) {
    switch (pixel_bytes_) {
      case 1:
        return filters.only_paeth ? decode<1, true>(filters) : decode<1, false>(filters);
      case 2:
        return filters.only_paeth ? decode<2, true>(filters) : decode<2, false>(filters);
      case 3:
        return decode<3, false>(filters);
      case 4:
        return decode<4, false>(filters);
      case 6:
        return decode<6, false>(filters);
      default:
        return decode<8, false>(filters);
    }
  }
  // The last row is above the next group's first.
  void keep_last() { std::copy_n(row(kLanes - 1), row_bytes_, above_.data()); }

 private:
  // The decoded bytes at and above the left neighbour of each lane's next byte; a pixel's bytes in
  // turn.
  template <std::size_t kPixel>
  struct Neighbours {
    Lanes left[kPixel] = {}, corner[kPixel] = {};
    std::size_t channel = 0;
  };

  template <std::size_t kPixel, bool kOnlyPaeth>
  static Lanes next(const Filters& filters, Lanes filtered, std::uint8_t first_above,
                    Neighbours<kPixel>& near) {
    Lanes& left = near.left[near.channel];
    Lanes& corner = near.corner[near.channel];
    const Lanes above = one_lane_on(left) | Lanes{first_above};
    left = (filtered + predicted<kOnlyPaeth>(filters, left, above, corner)) & 255;
    corner = above;
    if constexpr (kPixel > 1) near.channel = (near.channel + 1) % kPixel;
    return left;
  }

  template <std::size_t kPixel, bool kOnlyPaeth>
  void decode(const Filters& filters) {
    Neighbours<kPixel> near;
    for (std::size_t t = 0; t < row_bytes_ + margin_; t += kLanes) {
      Square square = gather(t);
      for (std::size_t i = 0; i < 4; ++i) {
        const std::uint8_t* first_above = above_.data() + t + 2 * i;
        const Lanes low =
            next<kPixel, kOnlyPaeth>(filters, low_lanes(square.part[i]), first_above[0], near);
        const Lanes high =
            next<kPixel, kOnlyPaeth>(filters, high_lanes(square.part[i]), first_above[1], near);
        square.part[i] = bytes_of(low, high);
      }
      scatter(square, t);
    }
  }

  // The bytes of the lanes at time t and the seven after it, a column for each time; and back.
  Square gather(std::size_t t) {
    const auto word = [&](std::size_t lane) {
      std::uint64_t bytes;
      std::memcpy(&bytes, row(lane) + t - lane * pixel_bytes_, kLanes);
      return bytes;
    };
    Square square;
    for (std::size_t i = 0; i < 4; ++i) {
      square.part[i] = reinterpret_cast<Bytes>(Words{word(2 * i), word(2 * i + 1)});
    }
    square.transpose();
    return square;
  }
  void scatter(Square square, std::size_t t) {
    square.transpose();
    for (std::size_t k = 0; k < kLanes; ++k) {
      const std::uint64_t bytes = reinterpret_cast<Words>(square.part[k / 2])[k % 2];
      std::memcpy(row(k) + t - k * pixel_bytes_, &bytes, kLanes);
    }
  }

  std::size_t row_bytes_, pixel_bytes_, margin_, stride_;
  std::vector<std::uint8_t> rows_, above_;
};

}  // namespace

bool unfilter_png_rows(
    std::span<const std::uint8_t> filtered, std::size_t row_bytes, std::size_t pixel_bytes,
    const std::function<void(std::size_t, std::span<const std::uint8_t>)>& take) {
  RowGroup group(row_bytes, pixel_bytes);
  const std::size_t rows = filtered.size() / (1 + row_bytes);
  for (std::size_t first = 0; first < rows; first += kLanes) {
    const std::size_t count = std::min(kLanes, rows - first);
    Filters filters;
    std::size_t good = 0;
    for (; good < count; ++good) {
      const std::uint8_t* row = filtered.data() + (first + good) * (1 + row_bytes);
      if (*row >= kFilters) break;
      filters.set(good, *row);
      std::copy_n(row + 1, row_bytes, group.row(good));
    }
    group.decode(filters);
    for (std::size_t k = 0; k < good; ++k) take(first + k, {group.row(k), row_bytes});
    if (good < count) return false;
    group.keep_last();
  }
  return true;
}

}  // namespace chasles
