#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace chasles {

/// The images of one camera that have 16 bits per value, and often use 10 or 12 of them.
struct DeepRange {
  int bits = 16;    ///< those used: 8, 10, 12, 14 or 16
  int largest = 0;  ///< value in the images that were looked at
  int images = 0;   ///< that were looked at
};

/// The largest value of a picture. One pixel in a thousand may be larger: a hot one, or damage.
/// `values`: at least one.
int largest_but_hot(std::vector<std::uint16_t> values);

/// Looks at up to nine images, spread evenly over a camera's `count`, so that one setting holds for
/// the whole recording: a range of each image's own would change the brightness from image to
/// image. `largest(i)`: the largest value of the i-th image, nothing if it has 8 bits; it may throw
/// InputError for an image that cannot be read, which is left out. Returns nothing if the first
/// image that can be read has 8 bits.
std::optional<DeepRange> deep_range(std::size_t count,
                                    const std::function<std::optional<int>(std::size_t)>& largest);

/// "the images of cam0 have 16 bits, and use 12 (…)".
std::string deep_remark(const DeepRange& range, const std::string& camera);

}  // namespace chasles
