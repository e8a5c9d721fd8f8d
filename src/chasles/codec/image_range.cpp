#include <algorithm>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/image_range.hpp>

namespace chasles {
namespace {

constexpr std::size_t kSampled = 9;

// The bits that sensors have.
int bits_for(int largest) {
  int bits = 8;
  while (bits < 16 && largest >> bits != 0) bits += 2;
  return bits;
}

}  // namespace

int largest_but_hot(std::vector<std::uint16_t> values) {
  const auto last = values.end() - 1 - static_cast<std::ptrdiff_t>(values.size() / 1000);
  std::nth_element(values.begin(), last, values.end());
  return *last;
}

std::optional<DeepRange> deep_range(std::size_t count,
                                    const std::function<std::optional<int>(std::size_t)>& largest) {
  DeepRange range;
  const std::size_t sampled = std::min(count, kSampled);
  for (std::size_t n = 0; n < sampled; ++n) {
    try {
      const std::optional<int> found = largest(sampled == 1 ? 0 : n * (count - 1) / (sampled - 1));
      if (!found && range.images == 0) return std::nullopt;
      if (!found) continue;
      ++range.images;
      range.largest = std::max(range.largest, *found);
    } catch (const InputError&) {  // is reported when it is its turn to be read
    }
  }
  if (range.images == 0) return std::nullopt;
  range.bits = bits_for(range.largest);
  return range;
}

std::string deep_remark(const DeepRange& range, const std::string& camera) {
  return fmt::format(
      "the images of {} have 16 bits and use {} of them (the largest value of {} images is {}): of "
      "these the eight highest are taken for the whole recording",
      camera, range.bits, range.images, range.largest);
}

}  // namespace chasles
