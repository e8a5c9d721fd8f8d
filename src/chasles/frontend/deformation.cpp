#include <cmath>
#include <cstdint>

#include <Eigen/Core>

#include <chasles/base/vector_clones.hpp>
#include <chasles/frontend/deformation.hpp>
#include <chasles/frontend/patch_sampling.hpp>

namespace chasles {
namespace {

using namespace sampling;

/// Model of the image under a patch with gain, offset, shift and bend: J = gain T + offset - gain
/// (dT/dx, dT/dy) (shift + bend o), linear in eight unknowns.
constexpr int kUnknowns = 8;
constexpr int kFirstBend = 4;
/// Factors of the bend, gradients times coordinates, are divided by this: the sums fit into 32
/// bits.
constexpr int kDivisor = 16;

/// The factors of the unknowns at the pixels of the patch, and the image as the last one.
template <int Lanes>
struct Factors {
  alignas(32) std::int16_t of[kUnknowns + 1][Patch::kMaxSide * Lanes];

  Factors(const Patch& patch, const std::int16_t* image) {
    const int half = patch.side / 2;
    alignas(32) std::int16_t inside[Lanes], x[Lanes];  // x in 32768 / kDivisor, for scaled()
    const auto coordinate = [](int o) { return static_cast<std::int16_t>(o * (32768 / kDivisor)); };
    for (int c = 0; c < Lanes; ++c) {
      inside[c] = c < patch.side ? 1 : 0;
      x[c] = c < patch.side ? coordinate(c - half) : 0;
    }
    for (int r = 0; r < patch.side; ++r) {
      const std::int16_t y = coordinate(r - half);
      for (int c = 0; c < Lanes; ++c) {
        const int i = r * Lanes + c;
        const std::int16_t d_x = patch.d_x[i], d_y = patch.d_y[i];
        of[0][i] = patch.value[i];
        of[1][i] = inside[c];
        of[2][i] = d_x;
        of[3][i] = d_y;
        of[4][i] = scaled(d_x, x[c]);
        of[5][i] = scaled(d_x, y);
        of[6][i] = scaled(d_y, x[c]);
        of[7][i] = scaled(d_y, y);
        of[8][i] = image[i];
      }
    }
  }
};

int dot(const std::int16_t* a, const std::int16_t* b, int count) {
  int sum = 0;
  for (int i = 0; i < count; ++i) sum += a[i] * b[i];
  return sum;
}

using Matrix8 = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Vector8 = Eigen::Matrix<double, kUnknowns, 1>;

/// Normal equations H x = b; the lower triangle of H.
struct Normal {
  Matrix8 H = Matrix8::Zero();
  Vector8 b;
};

/// x by Cholesky's method; none if H is not positive definite.
std::optional<Vector8> solution(Normal n) {
  for (int j = 0; j < kUnknowns; ++j) {
    double rest = n.H(j, j);
    for (int k = 0; k < j; ++k) rest -= n.H(j, k) * n.H(j, k);
    if (!(rest > 0)) return std::nullopt;
    n.H(j, j) = std::sqrt(rest);
    for (int i = j + 1; i < kUnknowns; ++i) {
      double product = n.H(i, j);
      for (int k = 0; k < j; ++k) product -= n.H(i, k) * n.H(j, k);
      n.H(i, j) = product / n.H(j, j);
    }
  }
  for (int i = 0; i < kUnknowns; ++i) {
    for (int k = 0; k < i; ++k) n.b[i] -= n.H(i, k) * n.b[k];
    n.b[i] /= n.H(i, i);
  }
  for (int i = kUnknowns - 1; i >= 0; --i) {
    for (int k = i + 1; k < kUnknowns; ++k) n.b[i] -= n.H(k, i) * n.b[k];
    n.b[i] /= n.H(i, i);
  }
  return n.b;
}

template <int Lanes>
std::optional<Deformation> deformation_lanes(const Patch& patch, const PyramidLevel& level,
                                             const Eigen::Vector2f& centre) {
  constexpr double kBendSigma = 0.02, kGreySigma = 5;  // from image to image; of one pixel
  constexpr double kLeastGain = 0.3;
  if (!inside(level, centre)) return std::nullopt;
  alignas(32) std::int16_t image[Patch::kMaxSide * Lanes];
  sample_straight<Lanes>(level, centre, patch.side, patch.side, image);
  const Factors<Lanes> factors(patch, image);
  const int count = patch.side * Lanes;
  Normal normal;
  for (int i = 0; i < kUnknowns; ++i) {
    for (int j = 0; j <= i; ++j) normal.H(i, j) = dot(factors.of[i], factors.of[j], count);
    normal.b[i] = dot(factors.of[i], factors.of[kUnknowns], count);
  }
  constexpr double kPrior = Patch::kUnit * kGreySigma / (kBendSigma * kDivisor);
  normal.H.diagonal().tail<kUnknowns - kFirstBend>().array() += kPrior * kPrior;
  const std::optional<Vector8> fit = solution(normal);
  if (!fit || !((*fit)[0] >= kLeastGain)) return std::nullopt;
  const Eigen::Matrix<float, kUnknowns, 1> parts = (-*fit / (*fit)[0]).cast<float>();
  Deformation result;
  result.shift = parts.segment<2>(2);
  result.bend << parts[4], parts[5], parts[6], parts[7];
  result.bend /= static_cast<float>(kDivisor);
  return result;
}

}  // namespace

CHASLES_VECTOR_CLONES
std::optional<Deformation> deformation(const Patch& patch, const PyramidLevel& level,
                                       const Eigen::Vector2f& centre) {
  return patch.side <= 16 ? deformation_lanes<16>(patch, level, centre)
                          : deformation_lanes<24>(patch, level, centre);
}

}  // namespace chasles
