#include <algorithm>
#include <cmath>

#include <Eigen/LU>

#include <chasles/base/vector_clones.hpp>
#include <chasles/frontend/patch.hpp>
#include <chasles/frontend/patch_sampling.hpp>

namespace chasles {
namespace {

using namespace sampling;

/// The sum of products of a patch's rows and others of `Stride` floats, lane by lane: strict
/// floating point forbids reordering of one sum, but allows one sum per lane.
template <int Lanes, int Stride = Patch::kLanes>
float dot(const float* a, const float* b, int side) {
  alignas(16) float sum[Lanes] = {};
  for (int r = 0; r < side; ++r) {
    for (int c = 0; c < Lanes; ++c) sum[c] += a[r * Patch::kLanes + c] * b[r * Stride + c];
  }
  float total = 0;
  for (const float s : sum) total += s;
  return total;
}

/// Writes Scharr's derivatives and the values of the patch with its ring into the patch's rows.
template <int Lanes>
void fill(const float* ringed, Patch& patch) {
  constexpr int ring = Lanes + 4;
  for (int c = 0; c < Lanes; ++c) patch.inside[c] = c < patch.side ? 1.0F : 0.0F;
  for (int r = 0; r < patch.side; ++r) {
    const float* p = ringed + (r + 1) * ring + 1;
    const float *above = p - ring, *below = p + ring;
    float* value = patch.value + r * Patch::kLanes;
    float* d_x = patch.d_x + r * Patch::kLanes;
    float* d_y = patch.d_y + r * Patch::kLanes;
    for (int c = 0; c < Lanes; ++c) {
      const float inside = patch.inside[c];
      value[c] = inside * p[c];
      d_x[c] = inside * (1.0F / 32) *
               (3 * (above[c + 1] - above[c - 1]) + 10 * (p[c + 1] - p[c - 1]) +
                3 * (below[c + 1] - below[c - 1]));
      d_y[c] = inside * (1.0F / 32) *
               (3 * (below[c - 1] - above[c - 1]) + 10 * (below[c] - above[c]) +
                3 * (below[c + 1] - above[c + 1]));
    }
  }
}

template <int Lanes>
float mean(const float* rows, int side) {
  alignas(16) float sum[Lanes] = {};
  for (int r = 0; r < side; ++r) {
    for (int c = 0; c < Lanes; ++c) sum[c] += rows[r * Patch::kLanes + c];
  }
  float total = 0;
  for (const float s : sum) total += s;
  return total / static_cast<float>(side * side);
}

/// rows - mean - share * value, inside the patch.
template <int Lanes>
void reduce(const Patch& patch, float mean, float share, float* rows) {
  for (int r = 0; r < patch.side; ++r) {
    for (int c = 0; c < Lanes; ++c) {
      const int i = r * Patch::kLanes + c;
      rows[i] -= patch.inside[c] * (mean + share * patch.value[i]);
    }
  }
}

/// Normalises values and gradients as the struct defines; false without texture.
template <int Lanes>
bool orthogonalise(float min_gradient, Patch& patch) {
  const int side = patch.side;
  const auto pixels = static_cast<float>(side * side);
  reduce<Lanes>(patch, mean<Lanes>(patch.value, side), 0, patch.value);
  patch.energy = dot<Lanes>(patch.value, patch.value, side);
  if (!(patch.energy > 0.1F * pixels)) return false;
  patch.overlap_x = dot<Lanes>(patch.value, patch.d_x, side) / patch.energy;
  patch.overlap_y = dot<Lanes>(patch.value, patch.d_y, side) / patch.energy;
  patch.mean_x = mean<Lanes>(patch.d_x, side);
  patch.mean_y = mean<Lanes>(patch.d_y, side);
  reduce<Lanes>(patch, patch.mean_x, patch.overlap_x, patch.d_x);
  reduce<Lanes>(patch, patch.mean_y, patch.overlap_y, patch.d_y);
  Eigen::Matrix2f H;
  H(0, 0) = dot<Lanes>(patch.d_x, patch.d_x, side);
  H(1, 1) = dot<Lanes>(patch.d_y, patch.d_y, side);
  H(0, 1) = H(1, 0) = dot<Lanes>(patch.d_x, patch.d_y, side);
  const float half_trace = (H(0, 0) + H(1, 1)) / 2;
  const float weakest =
      half_trace - std::hypot((H(0, 0) - H(1, 1)) / 2, H(0, 1));  // the smaller eigenvalue
  if (!(weakest >= std::max(min_gradient * min_gradient, 0.01F) * pixels)) return false;
  patch.inverse_hessian = H.inverse();
  return true;
}

/// Products of the image under the patch with the patch's rows, as needed for a step.
struct Products {
  float with_d_x = 0, with_d_y = 0, with_value = 0;
};

template <int Lanes>
Products products(const Patch& patch, const float* image) {
  alignas(16) float x[Lanes] = {}, y[Lanes] = {}, t[Lanes] = {};
  for (int r = 0; r < patch.side; ++r) {
    const float* J = image + r * Lanes;
    const int row = r * Patch::kLanes;
    for (int c = 0; c < Lanes; ++c) {
      x[c] += patch.d_x[row + c] * J[c];
      y[c] += patch.d_y[row + c] * J[c];
      t[c] += patch.value[row + c] * J[c];
    }
  }
  Products result;
  for (int c = 0; c < Lanes; ++c) {
    result.with_d_x += x[c];
    result.with_d_y += y[c];
    result.with_value += t[c];
  }
  return result;
}

template <int Lanes>
float correlation_of(const Patch& patch, const float* image, float with_value) {
  alignas(16) float sums[Lanes] = {}, more[Lanes] = {};
  for (int r = 0; r < patch.side; ++r) {
    for (int c = 0; c < Lanes; ++c) {
      const float J = image[r * Lanes + c] - 128;  // smaller squares have less round-off
      sums[c] += patch.inside[c] * J;
      more[c] += patch.inside[c] * J * J;
    }
  }
  float total = 0, squares = 0;
  for (int c = 0; c < Lanes; ++c) {
    total += sums[c];
    squares += more[c];
  }
  const auto pixels = static_cast<float>(patch.side * patch.side);
  const float energy = squares - total * total / pixels;
  if (!(energy > 0.1F * pixels)) return 0;
  return std::clamp(with_value / std::sqrt(energy * patch.energy), -1.0F, 1.0F);
}

/// The region around a point; it is read again if the patch leaves the last one.
template <int Lanes>
void inspect(const PyramidLevel& level, const Bilinear& at, int half, int side, bool first,
             Region& region) {
  const int x = at.x - half - region.x, y = at.y - half - region.y;
  if (!first && x >= 0 && y >= 0 && x <= 2 * kSlack && y <= 2 * kSlack) return;
  read_region<Lanes + 1 + 2 * kSlack>(level, at.x - half - kSlack, at.y - half - kSlack,
                                      side + 1 + 2 * kSlack, region);
}

template <int Lanes>
std::optional<PatchPosition> align_lanes(const Patch& patch, const PyramidLevel& level,
                                         const Eigen::Vector2f& start, int max_steps,
                                         float precision) {
  const int half = patch.side / 2;
  Region region;
  alignas(16) float image[Patch::kMaxSide * Lanes];
  PatchPosition found{.centre = start};
  for (int step = 0;; ++step) {
    if (!inside(level, found.centre)) return std::nullopt;
    const Bilinear at(found.centre);
    inspect<Lanes>(level, at, half, patch.side, step == 0, region);
    interpolate<Lanes>(region, at.x - half - region.x, at.y - half - region.y, at, patch.side,
                       image);
    const Products with = products<Lanes>(patch, image);
    const Eigen::Vector2f scaled =
        patch.inverse_hessian * Eigen::Vector2f(with.with_d_x, with.with_d_y);
    // The gain is bounded away from 0, so that a bad start causes no large step.
    const float gain =
        std::max(0.3F, with.with_value / patch.energy - patch.overlap_x * scaled.x() -
                           patch.overlap_y * scaled.y());
    const Eigen::Vector2f move = scaled / gain;
    const bool done = move.norm() < precision || step == max_steps;
    if (done) {
      found.correlation = correlation_of<Lanes>(patch, image, with.with_value);
      return found;
    }
    found.centre -= move;
    if (!((found.centre - start).norm() <= static_cast<float>(patch.side))) return std::nullopt;
  }
}

template <int Lanes>
float correlation_lanes(const Patch& patch, const PyramidLevel& level,
                        const Eigen::Vector2f& centre) {
  alignas(16) float image[Patch::kMaxSide * Lanes];
  sample_straight<Lanes>(level, centre, patch.side, image);
  return correlation_of<Lanes>(patch, image, dot<Lanes, Lanes>(patch.value, image, patch.side));
}

template <int Lanes>
bool make_patch_lanes(const PyramidLevel& level, const Eigen::Vector2f& centre,
                      const PatchShape& shape, float min_gradient, Patch& patch) {
  alignas(16) float ringed[(Patch::kMaxSide + 2) * (Lanes + 4)] = {};
  sample<Lanes + 4>(level, centre, shape, patch.side + 2, ringed);
  fill<Lanes>(ringed, patch);
  return orthogonalise<Lanes>(min_gradient, patch);
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
