#include <algorithm>

#include <Eigen/LU>

#include <chasles/frontend/deformation.hpp>
#include <chasles/frontend/follow.hpp>

namespace chasles {
namespace {

/// Settings for one level of the pyramid.
struct Pass {
  int level = 0;
  int max_steps = 10;
  float precision = 0.015F;      // [px of the level]
  float min_gradient = 0;        // [grey levels/px of the level]
  float min_correlation = 0.3F;  // a coarse level only provides a start
};

Pass coarse_pass(int level) {
  return {.level = level, .max_steps = 6, .precision = 0.1F, .min_gradient = 0.5F};
}

Pass fine_pass(const FollowSettings& settings) {
  return {.min_gradient = static_cast<float>(settings.min_gradient),
          .min_correlation = static_cast<float>(settings.min_correlation)};
}

/// The shape of the patch on a level. A prediction with a larger deformation than a rotation or a
/// lens can cause is not used.
PatchShape shape_of(const Expectation& expected, float scale) {
  const Eigen::Matrix2d from_A_to = expected.to_A_from.inverse();
  constexpr double kMostBow = 1;  // [1/px]
  const Bow& bow = expected.from_bow_to;
  const bool usable = from_A_to.allFinite() && from_A_to.cwiseAbs().maxCoeff() < 3 &&
                      bow.allFinite() && bow.cwiseAbs().maxCoeff() < kMostBow;
  if (!usable) return {};
  return {from_A_to.cast<float>(), bow.cast<float>() / scale};
}

/// Searches for the patch of `from`, given on level 0, around `estimate`; stores the patch in
/// `patch`.
std::optional<PatchPosition> search_patch(const ImagePyramid& from, const ImagePyramid& to,
                                          const Expectation& expected,
                                          const Eigen::Vector2f& estimate, int window,
                                          const Pass& pass, Patch& patch) {
  const auto l = static_cast<std::size_t>(pass.level);
  const float scale = 1.0F / static_cast<float>(1 << pass.level);
  if (!make_patch(from.levels[l], expected.from.cast<float>() * scale, shape_of(expected, scale),
                  window, pass.min_gradient, patch)) {
    return std::nullopt;
  }
  const auto found = align(patch, to.levels[l], estimate * scale, pass.max_steps, pass.precision);
  if (!found || found->correlation < pass.min_correlation) return std::nullopt;
  return found;
}

constexpr double kNear = 2.5;  // up to this distance, level 0 suffices [px]

// (o_x^2, o_x o_y, o_y^2) of A o, as a function of that of o.
Eigen::Matrix3d of_squares(const Eigen::Matrix2d& A) {
  const double a = A(0, 0), b = A(0, 1), c = A(1, 0), d = A(1, 1);
  Eigen::Matrix3d S;
  S << a * a, 2 * a * b, b * b, a * c, a * d + b * c, b * d, c * c, 2 * c * d, d * d;
  return S;
}

Expectation backward(const Expectation& forth, const Eigen::Vector2d& found) {
  const Eigen::Matrix2d from_A_to = forth.to_A_from.inverse();
  return {.from = found,
          .to = forth.from + from_A_to * (found - forth.to),
          .to_A_from = from_A_to,
          .levels = (found - forth.to).norm() < kNear ? 1 : forth.levels,
          .from_bow_to = -forth.to_A_from * forth.from_bow_to * of_squares(forth.to_A_from)};
}

}  // namespace

std::optional<PatchPosition> follow_forth(const ImagePyramid& from, const ImagePyramid& to,
                                          const Expectation& expected,
                                          const FollowSettings& settings) {
  const auto available = static_cast<int>(std::min(from.levels.size(), to.levels.size()));
  Eigen::Vector2f estimate = expected.to.cast<float>();
  Patch patch;
  // A coarse level that fails is skipped: the finer ones may succeed.
  for (int l = std::min(expected.levels, available) - 1; l > 0; --l) {
    const auto found =
        search_patch(from, to, expected, estimate, settings.window, coarse_pass(l), patch);
    if (found) estimate = found->centre * static_cast<float>(1 << l);
  }
  return search_patch(from, to, expected, estimate, settings.window, fine_pass(settings), patch);
}

Followed follow(const ImagePyramid& from, const ImagePyramid& to, const Expectation& expected,
                const FollowSettings& settings) {
  const std::optional<PatchPosition> forth = follow_forth(from, to, expected, settings);
  if (!forth) return {};
  const Eigen::Vector2d pixel = forth->centre.cast<double>();
  const std::optional<PatchPosition> back =
      follow_forth(to, from, backward(expected, pixel), settings);
  const bool returned =
      back && (back->centre.cast<double>() - expected.from).norm() <= settings.max_backward_error;
  return {.outcome = returned ? FollowOutcome::kFound : FollowOutcome::kBackward,
          .pixel = pixel,
          .correlation = static_cast<double>(forth->correlation)};
}

std::optional<Refound> find_again(const ImagePyramid& from, const ImagePyramid& to,
                                  const Expectation& expected, const FollowSettings& settings) {
  constexpr float kFurthest = 0.5F;  // [px], from the position that align() found
  Patch patch;
  const auto found = search_patch(from, to, expected, expected.to.cast<float>(), settings.window,
                                  fine_pass(settings), patch);
  if (!found) return std::nullopt;
  const auto rest = deformation(patch, to.levels[0], found->centre);
  if (!rest || rest->shift.norm() > kFurthest) return std::nullopt;
  const Eigen::Matrix2d bend = Eigen::Matrix2d::Identity() + rest->bend.cast<double>();
  return Refound{.pixel = (found->centre + rest->shift).cast<double>(),
                 .to_A_from = bend * expected.to_A_from};
}

}  // namespace chasles
