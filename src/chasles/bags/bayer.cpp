#include <cstddef>

#include <chasles/bags/bayer.hpp>
#include <chasles/codec/image_kinds.hpp>

namespace chasles {
namespace {

// Mirrored at the edge pixel itself, so that the colours stay where they are.
int mirrored(int i, int size) {
  if (size == 1) return 0;
  return i < 0 ? 1 : i == size ? size - 2 : i;
}

std::uint32_t quarter(std::uint32_t sum) { return (sum + 2) / 4; }

}  // namespace

std::vector<std::uint16_t> grey_of_mosaic(const std::vector<std::uint16_t>& mosaic, int width,
                                          int height, int red) {
  std::vector<std::uint16_t> grey(mosaic.size());
  for (int v = 0; v < height; ++v) {
    const auto row = [&](int dv) {
      return mosaic.data() + std::ptrdiff_t{mirrored(v + dv, height)} * width;
    };
    const std::uint16_t *above = row(-1), *here = row(0), *below = row(1);
    std::uint16_t* out = grey.data() + std::ptrdiff_t{v} * width;
    const bool red_row = v % 2 == red / 2;
    for (int u = 0; u < width; ++u) {
      const int l = mirrored(u - 1, width), r = mirrored(u + 1, width);
      const bool red_column = u % 2 == red % 2;
      // Four times each colour.
      const std::uint32_t own = 4u * here[u], aside = 2u * (here[l] + here[r]),
                          across = 2u * (above[u] + below[u]), around = (aside + across) / 2,
                          corners = std::uint32_t{above[l]} + above[r] + below[l] + below[r];
      const bool green = red_row != red_column;
      const std::uint32_t R4 = green ? (red_row ? aside : across) : red_row ? own : corners;
      const std::uint32_t B4 = green ? (red_row ? across : aside) : red_row ? corners : own;
      const std::uint32_t G4 = green ? own : around;
      out[u] = static_cast<std::uint16_t>(grey_of_colour(quarter(R4), quarter(G4), quarter(B4)));
    }
  }
  return grey;
}

}  // namespace chasles
