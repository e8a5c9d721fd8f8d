#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <chasles/loop/appearance.hpp>

namespace chasles {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr float kSameSide = 0.906F;    // cos 25 deg: a further view would say little more
constexpr float kComparable = 0.766F;  // cos 40 deg: beyond, a patch looks different
constexpr double kSteep = 0.5;         // sin 30 deg

// The direction in the image that is down on the upright patch: against gravity's pull where that
// is well visible, else along the map's first axis.
Vector3d upright(const Matrix3d& map_R_cam, const Vector3d& ray) {
  const auto across = [&](const Vector3d& axis) -> Vector3d { return axis - axis.dot(ray) * ray; };
  const Vector3d up = across(map_R_cam.row(2).transpose());
  if (up.norm() >= kSteep) return -up.normalized();
  return -across(map_R_cam.row(0).transpose()).normalized();
}

}  // namespace

std::optional<ViewPatches> view_patches(const Camera& camera, const Matrix3d& map_R_cam,
                                        const Vector3d& p_cam) {
  const auto seen = project(camera, p_cam);
  if (!seen) return std::nullopt;
  const Vector3d ray = p_cam.normalized();
  const Vector3d down = upright(map_R_cam, ray);
  Eigen::Matrix<double, 3, 2> axes;
  axes << down.cross(ray), down;
  const Eigen::Matrix2d per_metre = seen->d_point * axes;
  const double scale = std::sqrt(std::abs(per_metre.determinant()));  // [px/m]
  if (!(scale > 0) || !std::isfinite(scale)) return std::nullopt;
  ViewPatches result;
  result.view.from = -(map_R_cam * ray).cast<float>();
  result.view.level = static_cast<int>(std::lround(2 * std::log2(1e3 / scale)));
  for (int i = 0; i < PatchView::kLevels; ++i) {
    const double size = 1e-3 * std::exp2((result.view.level + i) / 2.0);  // [m]
    result.patches[static_cast<std::size_t>(i)] = {.centre = seen->pixel, .step = size * per_metre};
  }
  return result;
}

std::optional<int> distance(const PatchView& a, const PatchView& b) {
  const int level = std::max(a.level, b.level);
  if (level >= std::min(a.level, b.level) + PatchView::kLevels) return std::nullopt;
  return hamming_distance(a.descriptors[static_cast<std::size_t>(level - a.level)],
                          b.descriptors[static_cast<std::size_t>(level - b.level)]);
}

void Appearance::add(const PatchView& view) {
  if (views_.size() == kMostViews) return;
  const bool known = std::ranges::any_of(views_, [&](const PatchView& v) {
    return v.from.dot(view.from) > kSameSide && std::abs(v.level - view.level) <= 1;
  });
  if (!known) views_.push_back(view);
}

Appearance Appearance::turned(const Matrix3d& new_R_old) const {
  Appearance result;
  for (PatchView view : views_) {
    if (view.from.head<2>().norm() < static_cast<float>(kSteep)) continue;
    view.from = new_R_old.cast<float>() * view.from;
    result.views_.push_back(view);
  }
  return result;
}

bool Appearance::may_match(const PatchView& view) const {
  return std::ranges::any_of(views_, [&](const PatchView& v) {
    return v.from.dot(view.from) > kComparable &&
           std::abs(v.level - view.level) < PatchView::kLevels;
  });
}

std::optional<int> Appearance::distance(const PatchView& view) const {
  std::optional<int> least;
  for (const PatchView& v : views_) {
    if (v.from.dot(view.from) <= kComparable) continue;
    const auto d = chasles::distance(v, view);
    if (d && (!least || *d < *least)) least = d;
  }
  return least;
}

}  // namespace chasles
