#include <algorithm>

#include <chasles/base/median.hpp>
#include <chasles/reconstruct/sharpness.hpp>

namespace chasles {
namespace {

constexpr std::size_t kNeighbours = 5;  // on each side

// The sums of 2 x 2 pixels: half of the resolution.
struct HalfImage {
  explicit HalfImage(const GrayImage& image) : width(image.width / 2), height(image.height / 2) {
    sums.reserve(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (int y = 0; y < height; ++y) {
      const auto* above = image.pixels.data() + 2L * y * image.width;
      const auto* below = above + image.width;
      for (int x = 0; x < width; ++x, above += 2, below += 2) {
        sums.push_back(above[0] + above[1] + below[0] + below[1]);
      }
    }
  }
  const int* row(int y) const { return sums.data() + static_cast<std::ptrdiff_t>(y) * width; }

  int width, height;
  std::vector<int> sums;
};

}  // namespace

double sharpness(const GrayImage& image) {
  constexpr double kPixels = 4;  // of a sum
  const HalfImage half(image);
  double sum = 0, squares = 0, count = 0;
  for (int y = 1; y + 1 < half.height; ++y) {
    const int *above = half.row(y - 1), *here = half.row(y), *below = half.row(y + 1);
    for (int x = 1; x + 1 < half.width; ++x) {
      const double laplacian =
          (here[x - 1] + here[x + 1] + above[x] + below[x] - 4 * here[x]) / kPixels;
      sum += laplacian;
      squares += laplacian * laplacian;
      ++count;
    }
  }
  return count > 0 ? squares / count - sum / count * (sum / count) : 0;
}

std::vector<double> relative_sharpness(const std::vector<double>& values) {
  std::vector<double> relative(values.size(), 1);
  for (std::size_t i = 0; i < values.size(); ++i) {
    std::vector<double> neighbours;
    for (std::size_t j = i - std::min(i, kNeighbours);
         j < std::min(values.size(), i + kNeighbours + 1); ++j) {
      if (j != i) neighbours.push_back(values[j]);
    }
    if (neighbours.empty()) continue;
    const double usual = median(std::move(neighbours));
    if (usual > 0) relative[i] = values[i] / usual;
  }
  return relative;
}

}  // namespace chasles
