#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>

#include <Eigen/LU>

#include <chasles/base/vector_clones.hpp>
#include <chasles/frontend/corners.hpp>

namespace chasles {
namespace {

constexpr int kHalf = 3;  // of the window over which gradients are summed
constexpr int kSide = 2 * kHalf + 1;

/// Lengths of the rows of a box, as whole vectors: loops over them have no remainder. Columns
/// beyond the box are computed, and not looked at.
struct RowLengths {
  explicit RowLengths(std::size_t columns) : blocks((columns + 15) / 16) {}
  std::size_t blocks;

  std::size_t means() const { return 16 * blocks; }
  std::size_t pairs() const { return 16 * blocks + 8; }
  std::size_t sums() const { return 16 * blocks + 16; }
};

/// Gradients of a part of an image, twice the derivatives, row by row.
struct Gradients {
  Gradients(const PyramidLevel& image, int x, int y, const RowLengths& row_lengths,
            std::size_t rows)
      : lengths(row_lengths), columns(lengths.sums()), d_x(columns * rows), d_y(columns * rows) {
    for (std::size_t r = 0; r < rows; ++r) {
      const std::uint8_t* row = image.at(x, y + static_cast<int>(r));
      fill(row - 1, row + 1, d_x.data() + r * columns);
      fill(row - image.stride(), row + image.stride(), d_y.data() + r * columns);
    }
  }
  RowLengths lengths;
  std::size_t columns;
  std::vector<std::int16_t> d_x, d_y;

 private:
  void fill(const std::uint8_t* before, const std::uint8_t* after, std::int16_t* __restrict to) {
    const std::size_t count = lengths.sums();
    for (std::size_t c = 0; c < count; ++c) to[c] = static_cast<std::int16_t>(after[c] - before[c]);
  }
};

/// A row's sums of gradient products over kSide rows. Integers: adding and subtracting rows has no
/// round-off.
struct ColumnSums {
  explicit ColumnSums(const RowLengths& lengths)
      : row(lengths), xx(row.sums()), yy(row.sums()), xy(row.sums()) {}
  RowLengths row;
  std::vector<std::int32_t> xx, yy, xy;

  /// Adds the products of row `next`, and takes away those of row `last`, if any.
  void exchange(const Gradients& of, std::size_t next, std::optional<std::size_t> last) {
    const std::size_t columns = of.columns;
    add(of.d_x.data() + next * columns, of.d_y.data() + next * columns, 1);
    if (last) add(of.d_x.data() + *last * columns, of.d_y.data() + *last * columns, -1);
  }

 private:
  // The qualifiers exclude aliasing, so that the compiler vectorises the loop.
  void add(const std::int16_t* __restrict d_x, const std::int16_t* __restrict d_y, int sign) {
    const std::size_t columns = row.sums();
    std::int32_t* __restrict to_xx = xx.data(), * __restrict to_yy = yy.data(), * __restrict to_xy = xy.data();
    for (std::size_t c = 0; c < columns; ++c) {
      const auto signed_x = static_cast<std::int16_t>(sign * d_x[c]);
      const auto signed_y = static_cast<std::int16_t>(sign * d_y[c]);
      to_xx[c] += signed_x * d_x[c];
      to_yy[c] += signed_y * d_y[c];
      to_xy[c] += signed_x * d_y[c];
    }
  }
};

/// Means over kSide neighbours, of which pairs are added once.
void mean_along(const std::int32_t* __restrict from, const RowLengths& row,
                std::int32_t* __restrict pairs, float* __restrict to) {
  // Sums of kSide^2 products of gradients that are twice the derivative.
  constexpr float kMean = 1.0F / (4 * kSide * kSide);
  static_assert(kSide == 7);
  const std::size_t two = row.pairs(), all = row.means();
  for (std::size_t c = 0; c < two; ++c) pairs[c] = from[c] + from[c + 1];
  for (std::size_t c = 0; c < all; ++c) {
    to[c] = kMean * static_cast<float>(pairs[c] + pairs[c + 2] + pairs[c + 4] + from[c + 6]);
  }
}

/// Rows of a box's width from which the measure is computed.
struct MeanRows {
  explicit MeanRows(const RowLengths& row)
      : xx(row.means()), yy(row.means()), xy(row.means()), pairs(row.pairs()) {}
  std::vector<float> xx, yy, xy;
  std::vector<std::int32_t> pairs;  // sums of neighbours
};

/// The measure along a row; 0 where there is no corner.
void measure_row(const ColumnSums& sums, CornerMeasure measure, float min_eigenvalue,
                 MeanRows& means, float* __restrict out) {
  const std::size_t columns = sums.row.means();
  mean_along(sums.xx.data(), sums.row, means.pairs.data(), means.xx.data());
  mean_along(sums.yy.data(), sums.row, means.pairs.data(), means.yy.data());
  mean_along(sums.xy.data(), sums.row, means.pairs.data(), means.xy.data());
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

float larger(float a, float b) { return a > b ? a : b; }

/// The middle row, set to 0 where a neighbour is larger: few candidates remain for is_peak.
void keep_largest(const float* __restrict above, const float* __restrict row,
                  const float* __restrict below, const RowLengths& lengths,
                  float* __restrict highest, float* __restrict out) {
  const std::size_t columns = lengths.means();
  for (std::size_t c = 0; c < columns; ++c) {
    highest[c] = larger(larger(above[c], row[c]), below[c]);
  }
  for (std::size_t c = 0; c < columns; ++c) {  // of the next column: it has two neighbours
    const float largest = larger(larger(highest[c], highest[c + 1]), highest[c + 2]);
    out[c] = row[c + 1] >= largest ? row[c + 1] : 0.0F;
  }
}

constexpr int kReach = 4;  // half side of the window for refinement [px]

constexpr int kRefined = 2 * kReach + 1;  // side of that window
constexpr int kLanes = 16;                // of a row of it, with a pixel around it

/// Weights of the pixels of the window, and their offsets in x; 0 beyond it. The centre has the
/// largest weight, because another corner may be near.
struct RefinementWeights {
  alignas(32) float weight[kRefined][kLanes] = {};
  alignas(32) float x[kLanes] = {};

  constexpr RefinementWeights() {
    for (int r = 0; r < kRefined; ++r) {
      for (int c = 0; c < kRefined; ++c) {
        const int o_x = c - kReach, o_y = r - kReach;
        x[c] = static_cast<float>(o_x);
        weight[r][c] =
            1 / (1 + static_cast<float>(o_x * o_x + o_y * o_y) / (kReach * kReach / 4.0F));
      }
    }
  }
};
constexpr RefinementWeights kWeights;

float sum_of(const float* lanes) {
  float total = 0;
  for (int c = 0; c < kLanes; ++c) total += lanes[c];
  return total;
}

/// The point nearest to the lines perpendicular to the gradients around `centre`; not finite if all
/// are parallel.
Eigen::Vector2d gradient_intersection(const PyramidLevel& image, const Eigen::Vector2d& centre) {
  constexpr int rows = kRefined + 2, row = kLanes + 2;
  const int i = static_cast<int>(std::floor(centre.x())),
            j = static_cast<int>(std::floor(centre.y()));
  const auto u = static_cast<float>(centre.x() - i), v = static_cast<float>(centre.y() - j);
  float grey[rows][row];
  for (int r = 0; r < rows; ++r) {
    const std::uint8_t *p = image.at(i - kReach - 1, j - kReach - 1 + r), *q = p + image.stride();
    for (int c = 0; c < row; ++c) {
      const float above = static_cast<float>(p[c]) + u * static_cast<float>(p[c + 1] - p[c]);
      const float below = static_cast<float>(q[c]) + u * static_cast<float>(q[c + 1] - q[c]);
      grey[r][c] = above + v * (below - above);
    }
  }
  // Lane by lane: a fixed order, in which the compiler may use vectors.
  alignas(32) float xx[kLanes] = {}, xy[kLanes] = {}, yy[kLanes] = {}, x[kLanes] = {},
                    y[kLanes] = {};
  for (int r = 0; r < kRefined; ++r) {
    const auto o_y = static_cast<float>(r - kReach);
    for (int c = 0; c < kLanes; ++c) {
      const float g_x = grey[r + 1][c + 2] - grey[r + 1][c];
      const float g_y = grey[r + 2][c + 1] - grey[r][c + 1];
      const float w_x = kWeights.weight[r][c] * g_x, w_y = kWeights.weight[r][c] * g_y;
      const float along = g_x * kWeights.x[c] + g_y * o_y;
      xx[c] += w_x * g_x;
      xy[c] += w_x * g_y;
      yy[c] += w_y * g_y;
      x[c] += w_x * along;
      y[c] += w_y * along;
    }
  }
  Eigen::Matrix2f A;
  A(0, 0) = sum_of(xx);
  A(0, 1) = A(1, 0) = sum_of(xy);
  A(1, 1) = sum_of(yy);
  const Eigen::Vector2f towards = A.inverse() * Eigen::Vector2f(sum_of(x), sum_of(y));
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
  const RowLengths lengths(columns);
  ColumnSums sums(lengths);
  MeanRows means(lengths);
  const int y = box.y0 - 1;
  const auto rows_read = static_cast<std::size_t>(box.y1 - y + kSide);
  const Gradients gradients(image, box.x0 - 1 - kHalf, y - kHalf, lengths, rows_read);
  for (std::size_t r = 0; r + 1 < kSide; ++r) sums.exchange(gradients, r, {});
  const std::size_t stride = lengths.sums();
  std::vector<float> rows(5 * stride);
  float *above = rows.data(), *row = above + stride, *below = row + stride;
  float *const highest = below + stride, *const largest = highest + stride;
  for (int r = y; r <= box.y1; ++r) {
    const auto last_row = static_cast<std::size_t>(r - y) + kSide - 1;
    sums.exchange(gradients, last_row, r > y ? std::optional(last_row - kSide) : std::nullopt);
    measure_row(sums, measure, min_eigenvalue, means, below);
    if (r >= y + 2) keep_largest(above, row, below, lengths, highest, largest);
    for (std::size_t c = 1; r >= y + 2 && c + 1 < columns; ++c) {
      if (!(largest[c - 1] > 0) || !is_peak(above, row, below, c)) continue;
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
