#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include <chasles/base/vector_clones.hpp>
#include <chasles/frontend/patch.hpp>
#include <chasles/frontend/patch_sampling.hpp>

namespace chasles {
namespace {

using namespace sampling;

/// Writes the values of the patch with its ring, and Scharr's derivatives, into the patch's rows.
template <int Lanes>
void fill(const std::int16_t* ringed, Patch& patch) {
  constexpr int ring = Lanes + kRing;
  constexpr std::int16_t kThree = 3072, kTen = 10240;  // of 32, in 1/32768
  alignas(32) std::int16_t inside[Lanes];
  for (int c = 0; c < Lanes; ++c) inside[c] = c < patch.side ? -1 : 0;
  for (int r = 0; r < patch.side; ++r) {
    const std::int16_t* p = ringed + (r + 1) * ring + 1;
    const std::int16_t *above = p - ring, *below = p + ring;
    std::int16_t* value = patch.value + r * Lanes;
    std::int16_t* d_x = patch.d_x + r * Lanes;
    std::int16_t* d_y = patch.d_y + r * Lanes;
    for (int c = 0; c < Lanes; ++c) {
      const auto right = static_cast<std::int16_t>(above[c + 1] + below[c + 1]);
      const auto left = static_cast<std::int16_t>(above[c - 1] + below[c - 1]);
      const auto lower = static_cast<std::int16_t>(below[c - 1] + below[c + 1]);
      const auto upper = static_cast<std::int16_t>(above[c - 1] + above[c + 1]);
      const auto sides_x = static_cast<std::int16_t>(right - left);
      const auto sides_y = static_cast<std::int16_t>(lower - upper);
      const auto middle_x = static_cast<std::int16_t>(p[c + 1] - p[c - 1]);
      const auto middle_y = static_cast<std::int16_t>(below[c] - above[c]);
      const auto x = static_cast<std::int16_t>(scaled(sides_x, kThree) + scaled(middle_x, kTen));
      const auto y = static_cast<std::int16_t>(scaled(sides_y, kThree) + scaled(middle_y, kTen));
      value[c] = static_cast<std::int16_t>(p[c] & inside[c]);
      d_x[c] = static_cast<std::int16_t>(x & inside[c]);
      d_y[c] = static_cast<std::int16_t>(y & inside[c]);
    }
  }
}

/// Sums over the patch and of its products.
struct PatchSums {
  int t = 0, x = 0, y = 0, tt = 0, tx = 0, ty = 0, xx = 0, xy = 0, yy = 0;
};

template <int Lanes>
PatchSums sums_of(const Patch& patch) {
  PatchSums s;
  for (int i = 0; i < patch.side * Lanes; ++i) {
    const int t = patch.value[i], x = patch.d_x[i], y = patch.d_y[i];
    s.t += t;
    s.x += x;
    s.y += y;
    s.tt += t * t;
    s.tx += t * x;
    s.ty += t * y;
    s.xx += x * x;
    s.xy += x * y;
    s.yy += y * y;
  }
  return s;
}

/// Eliminates gain and offset; false without texture.
bool eliminate(const PatchSums& s, float min_gradient, Patch& patch) {
  const double pixels = patch.side * patch.side;
  const double least = pixels * Patch::kUnit * Patch::kUnit;  // of a grey level at each pixel
  patch.mean = s.t / pixels;
  patch.gradient = Eigen::Vector2d(s.x, s.y) / pixels;
  patch.energy = s.tt - s.t * patch.mean;
  if (!(patch.energy > 0.1 * least)) return false;
  const Eigen::Vector2d along = Eigen::Vector2d(s.tx, s.ty) - s.t * patch.gradient;
  patch.overlap = along / patch.energy;
  const double xx = s.xx - s.x * patch.gradient.x() - along.x() * patch.overlap.x();
  const double yy = s.yy - s.y * patch.gradient.y() - along.y() * patch.overlap.y();
  const double xy = s.xy - s.x * patch.gradient.y() - along.x() * patch.overlap.y();
  const double weakest =
      (xx + yy) / 2 - std::sqrt((xx - yy) * (xx - yy) / 4 + xy * xy);  // the smaller eigenvalue
  const double required = std::max(std::pow(static_cast<double>(min_gradient), 2), 0.01);
  if (!(weakest >= required * least)) return false;
  Eigen::Matrix2d H;
  H << xx, xy, xy, yy;
  patch.inverse_hessian = H.inverse();
  return true;
}

/// Sums over the image under the patch, and of its products with the patch.
struct ImageSums {
  int j = 0, jj = 0, tj = 0, xj = 0, yj = 0;
};

template <int Lanes>
ImageSums sums_with(const Patch& patch, const std::int16_t* image) {
  ImageSums s;
  for (int i = 0; i < patch.side * Lanes; ++i) {
    const int j = image[i];
    s.j += j;
    s.jj += j * j;
    s.tj += patch.value[i] * j;
    s.xj += patch.d_x[i] * j;
    s.yj += patch.d_y[i] * j;
  }
  return s;
}

/// The product of the image with the patch's values, without their means.
double with_value(const Patch& patch, const ImageSums& s) { return s.tj - patch.mean * s.j; }

float correlation_of(const Patch& patch, const ImageSums& s) {
  const double pixels = patch.side * patch.side;
  const double energy = s.jj - static_cast<double>(s.j) * s.j / pixels;
  if (!(energy > 0.1 * pixels * Patch::kUnit * Patch::kUnit)) return 0;
  const double normalised = with_value(patch, s) / std::sqrt(energy * patch.energy);
  return static_cast<float>(std::clamp(normalised, -1.0, 1.0));
}

/// One step of the search [px]: the patch lies so much further back.
Eigen::Vector2d step_of(const Patch& patch, const ImageSums& s) {
  const double value = with_value(patch, s);
  const Eigen::Vector2d slope =
      Eigen::Vector2d(s.xj, s.yj) - s.j * patch.gradient - value * patch.overlap;
  const Eigen::Vector2d scaled = patch.inverse_hessian * slope;
  // The gain is bounded away from 0, so that a bad start causes no large step.
  const double gain = std::max(0.3, value / patch.energy - patch.overlap.dot(scaled));
  return scaled / gain;
}

/// The region around a point; it is read again if the patch leaves the last one.
template <int Lanes>
void follow_region(const PyramidLevel& level, const Bilinear& at, int side, bool first,
                   Region<Lanes>& region) {
  const int x = at.x - side / 2 - region.x, y = at.y - side / 2 - region.y;
  if (!first && x >= 0 && y >= 0 && x <= 2 * kSlack && y <= 2 * kSlack) return;
  region.read(level, at.x - side / 2 - kSlack, at.y - side / 2 - kSlack, side + 1 + 2 * kSlack);
}

template <int Lanes>
std::optional<PatchPosition> align_lanes(const Patch& patch, const PyramidLevel& level,
                                         const Eigen::Vector2f& start, int max_steps,
                                         float precision) {
  const int half = patch.side / 2;
  Region<Lanes> region;
  alignas(32) std::int16_t image[Patch::kMaxSide * Lanes];
  PatchPosition found{.centre = start};
  for (int step = 0;; ++step) {
    if (!inside(level, found.centre)) return std::nullopt;
    const Bilinear at(found.centre);
    follow_region(level, at, patch.side, step == 0, region);
    interpolate(region, at.x - half - region.x, at.y - half - region.y, at, patch.side, patch.side,
                image);
    const ImageSums sums = sums_with<Lanes>(patch, image);
    const Eigen::Vector2f move = step_of(patch, sums).cast<float>();
    if (move.norm() < precision || step == max_steps) {
      found.correlation = correlation_of(patch, sums);
      return found;
    }
    found.centre -= move;
    if (!((found.centre - start).norm() <= static_cast<float>(patch.side))) return std::nullopt;
  }
}

template <int Lanes>
float correlation_lanes(const Patch& patch, const PyramidLevel& level,
                        const Eigen::Vector2f& centre) {
  alignas(32) std::int16_t image[Patch::kMaxSide * Lanes];
  sample_straight<Lanes>(level, centre, patch.side, patch.side, image);
  return correlation_of(patch, sums_with<Lanes>(patch, image));
}

template <int Lanes>
bool make_patch_lanes(const PyramidLevel& level, const Eigen::Vector2f& centre,
                      const PatchShape& shape, float min_gradient, Patch& patch) {
  alignas(32) std::int16_t ringed[(Patch::kMaxSide + 2) * (Lanes + kRing)];
  sample<Lanes + kRing>(level, centre, shape, patch.side + 2, ringed);
  fill<Lanes>(ringed, patch);
  return eliminate(sums_of<Lanes>(patch), min_gradient, patch);
}

}  // namespace

CHASLES_VECTOR_CLONES
bool make_patch(const PyramidLevel& level, const Eigen::Vector2f& centre, const PatchShape& shape,
                int side, float min_gradient, Patch& patch) {
  if (!inside(level, centre)) return false;
  patch.side = side;
  return side <= 16 ? make_patch_lanes<16>(level, centre, shape, min_gradient, patch)
                    : make_patch_lanes<24>(level, centre, shape, min_gradient, patch);
}

CHASLES_VECTOR_CLONES
std::optional<PatchPosition> align(const Patch& patch, const PyramidLevel& level,
                                   const Eigen::Vector2f& start, int max_steps, float precision) {
  return patch.side <= 16 ? align_lanes<16>(patch, level, start, max_steps, precision)
                          : align_lanes<24>(patch, level, start, max_steps, precision);
}

CHASLES_VECTOR_CLONES
float correlation(const Patch& patch, const PyramidLevel& level, const Eigen::Vector2f& centre) {
  return patch.side <= 16 ? correlation_lanes<16>(patch, level, centre)
                          : correlation_lanes<24>(patch, level, centre);
}

}  // namespace chasles
