#include <cmath>

#include <Eigen/LU>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/distortion.hpp>
#include <chasles/camera/stereo.hpp>

namespace chasles {

std::optional<PixelProjection> project(const Camera& camera, const Eigen::Vector3d& p_cam) {
  const double z = p_cam.z();
  if (!(z > kMinDepth) || !p_cam.allFinite()) return std::nullopt;
  const Eigen::Vector2d xy = p_cam.head<2>() / z;
  const std::optional<DistortedPoint> bent = distort(camera, xy);
  if (!bent) return std::nullopt;
  const Eigen::Vector2d focal(camera.fx, camera.fy);
  PixelProjection result;
  result.pixel = focal.cwiseProduct(bent->xy) + Eigen::Vector2d(camera.cx, camera.cy);
  result.d_point.leftCols<2>() = focal.asDiagonal() * bent->d_xy / z;
  result.d_point.col(2) = -result.d_point.leftCols<2>() * xy;
  if (!result.pixel.allFinite()) return std::nullopt;
  return result;
}

std::optional<PixelRay> unproject(const Camera& camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector2d focal(camera.fx, camera.fy);
  const Eigen::Vector2d on_plane =
      (pixel - Eigen::Vector2d(camera.cx, camera.cy)).cwiseQuotient(focal);
  const std::optional<Eigen::Vector2d> xy = undistort(camera, on_plane);
  if (!xy) return std::nullopt;
  const std::optional<DistortedPoint> bent = distort(camera, *xy);
  if (!bent) return std::nullopt;
  PixelRay result;
  result.ray << *xy, 1;
  result.d_pixel = bent->d_xy.inverse() * focal.cwiseInverse().asDiagonal();
  return result;
}

Eigen::Vector2d focal_lengths_at_axis(const Camera& camera) {
  const LensModel* model = find_lens_model(camera.distortion);
  const double slope = model && model->axis_slope ? model->axis_slope(camera.coefficients) : 1;
  return {camera.fx * slope, camera.fy * slope};
}

bool in_image(const Camera& camera, const Eigen::Vector2d& pixel, double border) {
  return pixel.x() >= border && pixel.x() <= camera.width - 1 - border &&  //
         pixel.y() >= border && pixel.y() <= camera.height - 1 - border;
}

}  // namespace chasles
