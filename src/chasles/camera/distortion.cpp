#include <chasles/camera/distortion.hpp>

namespace chasles {
namespace {

constexpr double kFarthestSquared = 1e200;  // beyond, squares overflow

}  // namespace

std::optional<DistortedPoint> distort(const Camera& camera, const Eigen::Vector2d& xy) {
  const LensModel* model = find_lens_model(camera.distortion);
  if (!model || !(xy.squaredNorm() < kFarthestSquared)) return std::nullopt;
  return model->distort(camera.coefficients, xy);
}

std::optional<Eigen::Vector2d> undistort(const Camera& camera, const Eigen::Vector2d& xy) {
  const LensModel* model = find_lens_model(camera.distortion);
  if (!model || !xy.allFinite()) return std::nullopt;
  return model->undistort(camera.coefficients, xy);
}

}  // namespace chasles
