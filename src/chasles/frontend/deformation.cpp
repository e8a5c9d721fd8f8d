#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include <Eigen/Cholesky>

#include <chasles/base/vector_clones.hpp>
#include <chasles/frontend/deformation.hpp>
#include <chasles/frontend/patch_sampling.hpp>

namespace chasles {
namespace {

using namespace sampling;

/// Model of the image under a patch with gain, offset, shift and bend: J = gain T + offset - gain
/// (dT/dx, dT/dy) (shift + bend o), linear in eight unknowns. The factor of each unknown is one of
/// these, for some multiplied by the pixel's x, which is the same in all rows.
enum Factor { kValue, kOne, kGradientX, kGradientY, kGradientXTimesY, kGradientYTimesY, kImage };
constexpr int kFactors = kImage + 1;

struct Unknown {
  Factor factor;
  bool times_x = false;
};
constexpr std::array<Unknown, 8> kUnknowns{{{kValue},
                                            {kOne},
                                            {kGradientX},
                                            {kGradientY},
                                            {kGradientX, true},
                                            {kGradientXTimesY},
                                            {kGradientY, true},
                                            {kGradientYTimesY}}};

/// Sums over the rows of the products of two factors, lane by lane.
template <int Lanes>
struct FactorProducts {
  alignas(16) float sum[kFactors][kFactors][Lanes] = {};  // second index at most the first

  FactorProducts(const Patch& patch, const std::int16_t* image) {
    constexpr float kGrey = 1.0F / Patch::kUnit;
    const auto mean = static_cast<float>(patch.mean);
    alignas(16) float f[kFactors][Lanes];
    for (int r = 0; r < patch.side; ++r) {
      const int row = r * Lanes;
      const auto y = static_cast<float>(r - patch.side / 2);
      for (int c = 0; c < Lanes; ++c) {
        const float in = c < patch.side ? 1.0F : 0.0F;
        f[kValue][c] = kGrey * in * (patch.value[row + c] - mean);  // smaller: less round-off
        f[kOne][c] = in;
        f[kGradientX][c] = kGrey * patch.d_x[row + c];
        f[kGradientY][c] = kGrey * patch.d_y[row + c];
        f[kGradientXTimesY][c] = y * f[kGradientX][c];
        f[kGradientYTimesY][c] = y * f[kGradientY][c];
        f[kImage][c] = kGrey * image[row + c];
      }
      for (int i = 0; i < kFactors; ++i) {
        for (int j = 0; j <= i; ++j) {
          for (int c = 0; c < Lanes; ++c) sum[i][j][c] += f[i][c] * f[j][c];
        }
      }
    }
  }

  /// The sum over the patch of the products of two unknowns' factors.
  float operator()(Unknown a, Unknown b, int side) const {
    if (a.factor < b.factor) std::swap(a, b);
    const int power = (a.times_x ? 1 : 0) + (b.times_x ? 1 : 0);
    float total = 0;
    for (int c = 0; c < side; ++c) {
      const auto x = static_cast<float>(c - side / 2);
      const float weight = power == 0 ? 1 : (power == 1 ? x : x * x);
      total += weight * sum[a.factor][b.factor][c];
    }
    return total;
  }
};

template <int Lanes>
std::optional<Deformation> deformation_lanes(const Patch& patch, const PyramidLevel& level,
                                             const Eigen::Vector2f& centre) {
  constexpr float kBendSigma = 0.02F, kGreySigma = 5;  // from image to image; of one pixel
  if (!inside(level, centre)) return std::nullopt;
  alignas(32) std::int16_t image[Patch::kMaxSide * Lanes];
  sample_straight<Lanes>(level, centre, patch.side, patch.side, image);
  const FactorProducts<Lanes> products(patch, image);
  Eigen::Matrix<float, 8, 8> H = Eigen::Matrix<float, 8, 8>::Zero();
  Eigen::Matrix<float, 8, 1> b;
  for (std::size_t i = 0; i < kUnknowns.size(); ++i) {
    for (std::size_t j = 0; j <= i; ++j) {
      H(static_cast<int>(i), static_cast<int>(j)) =
          products(kUnknowns[i], kUnknowns[j], patch.side);
    }
    b(static_cast<int>(i)) = products(kUnknowns[i], {kImage}, patch.side);
  }
  H.diagonal().tail<4>().array() += kGreySigma * kGreySigma / (kBendSigma * kBendSigma);
  const Eigen::Matrix<float, 8, 1> fit = H.selfadjointView<Eigen::Lower>().ldlt().solve(b);
  const float gain = fit(0);
  if (!fit.allFinite() || gain < 0.3F) return std::nullopt;
  Deformation result;
  result.shift = -fit.segment<2>(2) / gain;
  result.bend << -fit(4), -fit(5), -fit(6), -fit(7);
  result.bend /= gain;
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
