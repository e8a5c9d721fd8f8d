#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include <Eigen/LU>

#include <chasles/target/saddle_points.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;

constexpr int kRingSamples = 32;
constexpr double kRingRadius = 3;      // [px] of a level
constexpr float kLeastResponse = 6;    // of the determinant: noise of 5 grey values stays below
constexpr double kLeastContrast = 12;  // grey values
constexpr int kLeastLevelSize = 100;   // [px]: smaller levels show no board
constexpr int kMostLevels = 3;
constexpr double kTwoPi = 2 * std::numbers::pi;

using Ring = std::array<double, kRingSamples>;

const std::array<Vector2d, kRingSamples>& ring_offsets() {
  static const auto offsets = [] {
    std::array<Vector2d, kRingSamples> result;
    for (int k = 0; k < kRingSamples; ++k) {
      const double angle = kTwoPi * k / kRingSamples;
      result[static_cast<std::size_t>(k)] =
          kRingRadius * Vector2d(std::cos(angle), std::sin(angle));
    }
    return result;
  }();
  return offsets;
}

// Ixy^2 - Ixx Iyy: positive at saddles.
GreyPlane saddle_response(const GreyPlane& image) {
  GreyPlane result{image.width, image.height, std::vector<float>(image.values.size(), 0.0F)};
  for (int y = 1; y + 1 < image.height; ++y) {
    const float* above = image.row(y - 1);
    const float* here = image.row(y);
    const float* below = image.row(y + 1);
    float* out = result.row(y);
    for (int x = 1; x + 1 < image.width; ++x) {
      const float xx = here[x + 1] - 2 * here[x] + here[x - 1];
      const float yy = below[x] - 2 * here[x] + above[x];
      const float xy = (below[x + 1] - below[x - 1] - above[x + 1] + above[x - 1]) / 4;
      out[x] = xy * xy - xx * yy;
    }
  }
  return result;
}

bool is_peak(const GreyPlane& response, int x, int y) {
  const float value = response.row(y)[x];
  if (value < kLeastResponse) return false;
  for (int dy = -2; dy <= 2; ++dy) {
    const float* row = response.row(y + dy);
    for (int dx = -2; dx <= 2; ++dx) {
      // Of equal neighbours the last one is the peak.
      if (dy > 0 || (dy == 0 && dx > 0) ? row[x + dx] >= value : row[x + dx] > value) {
        if (dx != 0 || dy != 0) return false;
      }
    }
  }
  return true;
}

// Where the gradient of the surface around a pixel is zero.
std::optional<Vector2d> stationary_point(const GreyPlane& image, int x, int y) {
  const float* a = image.row(y - 1) + x;
  const float* h = image.row(y) + x;
  const float* b = image.row(y + 1) + x;
  Eigen::Matrix2d hessian;
  hessian(0, 0) = static_cast<double>(h[1] - 2 * h[0] + h[-1]);
  hessian(1, 1) = static_cast<double>(b[0] - 2 * h[0] + a[0]);
  hessian(0, 1) = hessian(1, 0) = static_cast<double>(b[1] - b[-1] - a[1] + a[-1]) / 4;
  const Vector2d gradient(static_cast<double>(h[1] - h[-1]) / 2,
                          static_cast<double>(b[0] - a[0]) / 2);
  if (hessian.determinant() >= 0) return std::nullopt;
  const Vector2d offset = -hessian.inverse() * gradient;
  if (offset.cwiseAbs().maxCoeff() > 1.5) return std::nullopt;
  return Vector2d(x, y) + offset;
}

// The angles at which the ring crosses the middle value; none unless there are four, from dark to
// light and back, by clear steps.
std::optional<std::array<double, 4>> crossings(const Ring& ring, double middle, double margin) {
  std::array<double, 4> result{};
  std::size_t count = 0, first = kRingSamples;
  for (std::size_t k = 0; k < kRingSamples && first == kRingSamples; ++k) {
    if (ring[k] > middle + margin) first = k;
  }
  if (first == kRingSamples) return std::nullopt;
  bool light = true;
  double last = 0;  // the latest crossing of the middle
  for (std::size_t j = 1; j <= kRingSamples; ++j) {
    const double before = ring[(first + j - 1) % kRingSamples] - middle;
    const double here = ring[(first + j) % kRingSamples] - middle;
    if ((before > 0) != (here > 0)) {
      last = static_cast<double>(first + j - 1) + before / (before - here);
    }
    if (light ? here < -margin : here > margin) {
      if (count == 4) return std::nullopt;
      result[count++] = last * kTwoPi / kRingSamples;
      light = !light;
    }
  }
  return count == 4 && light ? std::optional(result) : std::nullopt;
}

// Edges go straight through the point, and no sector is narrow.
bool is_cross(const std::array<double, 4>& edges) {
  constexpr double kBend = 0.5, kNarrow = 0.35;  // [rad]
  for (std::size_t k = 0; k < 4; ++k) {
    const double next = edges[(k + 1) % 4] + (k == 3 ? kTwoPi : 0);
    if (next - edges[k] < kNarrow) return false;
  }
  return std::abs(edges[2] - edges[0] - std::numbers::pi) < kBend &&
         std::abs(edges[3] - edges[1] - std::numbers::pi) < kBend;
}

std::optional<SaddlePoint> measured(const GreyPlane& image, const Vector2d& pixel,
                                    double response) {
  if (!image.contains(pixel, kRingRadius + 1)) return std::nullopt;
  Ring ring;
  for (std::size_t k = 0; k < kRingSamples; ++k) {
    ring[k] = static_cast<double>(image.at(pixel + ring_offsets()[k]));
  }
  Ring sorted = ring;
  std::ranges::sort(sorted);
  const double dark = sorted[kRingSamples / 8], light = sorted[kRingSamples - 1 - kRingSamples / 8];
  if (light - dark < kLeastContrast) return std::nullopt;
  const auto edges = crossings(ring, (dark + light) / 2, 0.15 * (light - dark));
  if (!edges || !is_cross(*edges)) return std::nullopt;
  // A product of two edges of contrast c, blurred by s, has the determinant (c sin / (pi s^2))^2.
  const double sine = std::abs(std::sin((*edges)[1] - (*edges)[0]));
  const double variance = (light - dark) * sine / (std::numbers::pi * std::sqrt(response));
  return SaddlePoint{.pixel = pixel,
                     .edges = *edges,
                     .dark = dark,
                     .light = light,
                     .blur = std::sqrt(std::max(0.0, variance - 1.25))};
}

std::vector<SaddlePoint> saddle_points_of(const GreyPlane& image) {
  std::vector<SaddlePoint> result;
  const GreyPlane response = saddle_response(image);
  for (int y = 4; y + 4 < image.height; ++y) {
    for (int x = 4; x + 4 < image.width; ++x) {
      if (response.row(y)[x] < kLeastResponse || !is_peak(response, x, y)) continue;
      const auto pixel = stationary_point(image, x, y);
      if (!pixel) continue;
      const double value = static_cast<double>(response.row(y)[x]);
      if (auto point = measured(image, *pixel, value)) result.push_back(*point);
    }
  }
  return result;
}

// Every second pixel of every second row.
GreyPlane halved(const GreyPlane& image) {
  GreyPlane result{(image.width + 1) / 2, (image.height + 1) / 2, {}};
  result.values.resize(static_cast<std::size_t>(result.width) * result.height);
  for (int y = 0; y < result.height; ++y) {
    const float* in = image.row(2 * y);
    float* out = result.row(y);
    for (int x = 0; x < result.width; ++x) out[x] = in[2 * x];
  }
  return result;
}

// Adds the points that no finer level has.
void add_coarse(const std::vector<SaddlePoint>& coarse, double scale,
                std::vector<SaddlePoint>& result) {
  const std::size_t fine = result.size();
  for (SaddlePoint point : coarse) {
    point.pixel *= scale;
    point.blur *= scale;
    const bool known = std::any_of(
        result.begin(), result.begin() + static_cast<std::ptrdiff_t>(fine),
        [&](const SaddlePoint& other) { return (other.pixel - point.pixel).norm() < 1.5 * scale; });
    if (!known) result.push_back(point);
  }
}

}  // namespace

float GreyPlane::at(const Vector2d& pixel) const {
  const int x = std::clamp(static_cast<int>(pixel.x()), 0, width - 2);
  const int y = std::clamp(static_cast<int>(pixel.y()), 0, height - 2);
  const float a = static_cast<float>(pixel.x() - x), b = static_cast<float>(pixel.y() - y);
  const float* above = row(y) + x;
  const float* below = row(y + 1) + x;
  return (1 - b) * ((1 - a) * above[0] + a * above[1]) + b * ((1 - a) * below[0] + a * below[1]);
}

bool GreyPlane::contains(const Vector2d& pixel, double border) const {
  return pixel.x() >= border && pixel.y() >= border && pixel.x() <= width - 1 - border &&
         pixel.y() <= height - 1 - border;
}

GreyPlane grey_plane(const GrayImage& image) {
  return {image.width, image.height, {image.pixels.begin(), image.pixels.end()}};
}

GreyPlane smoothed(const GreyPlane& image) {
  const int w = image.width, h = image.height;
  GreyPlane result{w, h, std::vector<float>(image.values.size())};
  std::vector<float> line(static_cast<std::size_t>(w) + 4);
  for (int y = 0; y < h; ++y) {
    const float* a = image.row(std::max(0, y - 2));
    const float* b = image.row(std::max(0, y - 1));
    const float* c = image.row(y);
    const float* d = image.row(std::min(h - 1, y + 1));
    const float* e = image.row(std::min(h - 1, y + 2));
    float* middle = line.data() + 2;
    for (int x = 0; x < w; ++x) middle[x] = (a[x] + e[x] + 4 * (b[x] + d[x]) + 6 * c[x]) / 16;
    middle[-2] = middle[-1] = middle[0];
    middle[w] = middle[w + 1] = middle[w - 1];
    float* out = result.row(y);
    for (int x = 0; x < w; ++x) {
      out[x] =
          (middle[x - 2] + middle[x + 2] + 4 * (middle[x - 1] + middle[x + 1]) + 6 * middle[x]) /
          16;
    }
  }
  return result;
}

std::vector<SaddlePoint> find_saddle_points(const GreyPlane& image) {
  std::vector<SaddlePoint> result;
  GreyPlane level = smoothed(image);
  double scale = 1;
  for (int k = 0;
       k < kMostLevels && std::min(level.width, level.height) >= (k == 0 ? 16 : kLeastLevelSize);
       ++k) {
    if (k > 0) {
      level = smoothed(halved(level));
      scale *= 2;
    }
    add_coarse(saddle_points_of(level), scale, result);
  }
  return result;
}

}  // namespace chasles
