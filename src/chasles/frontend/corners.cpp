#include <algorithm>
#include <cmath>
#include <cstddef>

#include <Eigen/LU>

#include <chasles/base/vector_clones.hpp>
#include <chasles/frontend/corners.hpp>

namespace chasles {
namespace {

constexpr int kHalf = 3;  // of the window over which gradients are summed
constexpr int kSide = 2 * kHalf + 1;

/// Rows of sums of gradient products, over kSide rows above and below the present one. All numbers
/// are integers below 2^24, so that floats represent them exactly, and adding and subtracting has
/// no round-off.
struct ColumnSums {
  explicit ColumnSums(std::size_t columns) : xx(columns), yy(columns), xy(columns) {}
  std::vector<float> xx, yy, xy;

  /// Adds (sign 1) or takes away (-1) the products of the image's row y from column x on.
  void add(const PyramidLevel& image, int x, int y, float sign) {
    const std::uint8_t *row = image.at(x, y), *above = image.at(x, y - 1),
                       *below = image.at(x, y + 1);
    const std::size_t columns = xx.size();
    // The qualifiers exclude aliasing, so that the compiler vectorises the loop.
    float* __restrict to_xx = xx.data(), * __restrict to_yy = yy.data(), * __restrict to_xy = xy.data();
    for (std::size_t c = 0; c < columns; ++c) {
      const auto d_x = static_cast<float>(row[c + 1] - row[static_cast<std::ptrdiff_t>(c) - 1]);
      const auto d_y = static_cast<float>(below[c] - above[c]);
      to_xx[c] += sign * d_x * d_x;
      to_yy[c] += sign * d_y * d_y;
      to_xy[c] += sign * d_x * d_y;
    }
  }
};

/// Sums of kSide neighbours.
void sum_along(const float* __restrict from, std::size_t columns, float* __restrict to) {
  // Sums of kSide^2 products of gradients that are twice the derivative.
  constexpr float kMean = 1.0F / (4 * kSide * kSide);
  for (std::size_t c = 0; c < columns; ++c) {
    float sum = 0;
    for (std::size_t k = 0; k < kSide; ++k) sum += from[c + k];
    to[c] = kMean * sum;
  }
}

/// Rows of a box's width from which the measure is computed.
struct MeanRows {
  explicit MeanRows(std::size_t columns) : xx(columns), yy(columns), xy(columns) {}
  std::vector<float> xx, yy, xy;
};

/// The measure along a row; 0 where there is no corner.
void measure_row(const ColumnSums& sums, CornerMeasure measure, float min_eigenvalue,
                 MeanRows& means, float* __restrict out) {
  const std::size_t columns = means.xx.size();
  sum_along(sums.xx.data(), columns, means.xx.data());
  sum_along(sums.yy.data(), columns, means.yy.data());
  sum_along(sums.xy.data(), columns, means.xy.data());
  const float *__restrict xx = means.xx.data(), *__restrict yy = means.yy.data(),
              *__restrict xy = means.xy.data();
  for (std::size_t c = 0; c < columns; ++c) {
    const float trace = xx[c] + yy[c];
    const float score = xx[c] * yy[c] - xy[c] * xy[c] - 0.04F * trace * trace;
    // Both eigenvalues are at least m if M - m I has neither a negative trace nor a negative
    // determinant.
    const float a = xx[c] - min_eigenvalue, b = yy[c] - min_eigenvalue;
    const float smallest = std::min({a * b - xy[c] * xy[c], a + b, score});
    out[c] = smallest >= 0 ? score : 0.0F;
  }
  if (measure == CornerMeasure::kHarris) return;
  for (std::size_t c = 0; c < columns; ++c) {
    const float trace = xx[c] + yy[c], difference = xx[c] - yy[c];
    const float smaller = 0.5F * (trace - std::sqrt(difference * difference + 4 * xy[c] * xy[c]));
    out[c] = smaller >= min_eigenvalue ? smaller : 0.0F;
  }
}

/// Whether the element of the middle row exceeds its eight neighbours; of equal ones the first
/// counts.
bool is_peak(const float* above, const float* row, const float* below, std::size_t c) {
  const float s = row[c];
  return s > above[c - 1] && s > above[c] && s > above[c + 1] && s > row[c - 1] &&
         s >= row[c + 1] && s >= below[c - 1] && s >= below[c] && s >= below[c + 1];
}

/// The middle row, set to 0 where a neighbour is larger: few candidates remain for is_peak.
void keep_largest(const float* __restrict above, const float* __restrict row,
                  const float* __restrict below, std::size_t columns, float* __restrict out) {
  for (std::size_t c = 1; c + 1 < columns; ++c) {
    const float before = std::max(std::max(above[c - 1], row[c - 1]), below[c - 1]);
    const float behind = std::max(std::max(above[c + 1], row[c + 1]), below[c + 1]);
    const float largest = std::max(std::max(before, behind), std::max(above[c], below[c]));
    out[c] = row[c] >= largest ? row[c] : 0.0F;
  }
}

constexpr int kReach = 4;  // half side of the window for refinement [px]

/// The point nearest to the lines perpendicular to the gradients around `centre`; not finite if all
/// are parallel.
Eigen::Vector2d gradient_intersection(const PyramidLevel& image, const Eigen::Vector2d& centre) {
  constexpr int side = 2 * kReach + 3;
  const int i = static_cast<int>(std::floor(centre.x())),
            j = static_cast<int>(std::floor(centre.y()));
  const auto u = static_cast<float>(centre.x() - i), v = static_cast<float>(centre.y() - j);
  float grey[side][side];
  for (int r = 0; r < side; ++r) {
    const std::uint8_t *p = image.at(i - kReach - 1, j - kReach - 1 + r), *q = p + image.stride();
    for (int c = 0; c < side; ++c) {
      const float above = static_cast<float>(p[c]) + u * static_cast<float>(p[c + 1] - p[c]);
      const float below = static_cast<float>(q[c]) + u * static_cast<float>(q[c + 1] - q[c]);
      grey[r][c] = above + v * (below - above);
    }
  }
  Eigen::Matrix2f A = Eigen::Matrix2f::Zero();
  Eigen::Vector2f b = Eigen::Vector2f::Zero();
  for (int r = 1; r + 1 < side; ++r) {
    for (int c = 1; c + 1 < side; ++c) {
      const Eigen::Vector2f offset(static_cast<float>(c - kReach - 1),
                                   static_cast<float>(r - kReach - 1));
      const Eigen::Vector2f g(grey[r][c + 1] - grey[r][c - 1], grey[r + 1][c] - grey[r - 1][c]);
      // The centre has the largest weight, because another corner may be near.
      const float weight = 1 / (1 + offset.squaredNorm() / (kReach * kReach / 4.0F));
      A += weight * g * g.transpose();
      b += weight * g.dot(offset) * g;
    }
  }
  const Eigen::Vector2f towards = A.inverse() * b;
  return centre + towards.cast<double>();
}

}  // namespace

CHASLES_VECTOR_CLONES
std::vector<Corner> find_corners(const PyramidLevel& image, const PixelBox& box,
                                 CornerMeasure measure, double min_gradient) {
  std::vector<Corner> corners;
  if (box.empty()) return corners;
  // One more column and row on each side, for the test of maxima.
  const auto columns = static_cast<std::size_t>(box.x1 - box.x0 + 2);
  const auto min_eigenvalue = static_cast<float>(min_gradient * min_gradient);
  ColumnSums sums(columns + 2 * kHalf);
  MeanRows means(columns);
  const int x = box.x0 - 1 - kHalf, y = box.y0 - 1;
  for (int dy = -kHalf; dy < kHalf; ++dy) sums.add(image, x, y + dy, 1);
  std::vector<float> rows(3 * columns), largest(columns);
  float *above = rows.data(), *row = above + columns, *below = row + columns;
  for (int r = y; r <= box.y1; ++r) {
    sums.add(image, x, r + kHalf, 1);
    measure_row(sums, measure, min_eigenvalue, means, below);
    sums.add(image, x, r - kHalf, -1);
    if (r >= y + 2) keep_largest(above, row, below, columns, largest.data());
    for (std::size_t c = 1; r >= y + 2 && c + 1 < columns; ++c) {
      if (!(largest[c] > 0) || !is_peak(above, row, below, c)) continue;
      corners.push_back({.pixel = {box.x0 - 1 + static_cast<double>(c), r - 1.0}, .score = row[c]});
    }
    float* const oldest = above;
    above = row;
    row = below;
    below = oldest;
  }
  std::stable_sort(corners.begin(), corners.end(),
                   [](const Corner& a, const Corner& b) { return a.score > b.score; });
  return corners;
}

CHASLES_VECTOR_CLONES
Eigen::Vector2d refine_corner(const PyramidLevel& image, const Eigen::Vector2d& pixel) {
  constexpr int kSteps = 8;
  Eigen::Vector2d estimate = pixel;
  for (int step = 0; step < kSteps; ++step) {
    const Eigen::Vector2d moved = gradient_intersection(image, estimate);
    const bool inside = moved.x() >= 0 && moved.y() >= 0 && moved.x() <= image.width - 1 &&
                        moved.y() <= image.height - 1;
    if (!inside || !((moved - pixel).norm() <= kReach)) return pixel;
    const double move = (moved - estimate).norm();
    estimate = moved;
    if (move < 0.02) break;
  }
  return estimate;
}

}  // namespace chasles
