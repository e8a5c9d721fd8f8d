#include <cmath>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/distortion.hpp>
#include <chasles/camera/stereo.hpp>

namespace chasles {

namespace {

// Any direction that the lens sees, of a point at this distance.
std::optional<PixelProjection> project_bearing(const Camera& camera, const Eigen::Vector3d& p_cam) {
  const LensModel* model = find_lens_model(camera.distortion);
  const double distance = p_cam.stableNorm();
  if (!model || !model->distort_bearing || !(distance > kMinDepth)) return std::nullopt;
  const auto bent = model->distort_bearing(camera.coefficients, p_cam / distance);
  if (!bent) return std::nullopt;
  const Eigen::Vector2d focal(camera.fx, camera.fy);
  PixelProjection result;
  result.pixel = focal.cwiseProduct(bent->xy) + Eigen::Vector2d(camera.cx, camera.cy);
  result.d_point = focal.asDiagonal() * bent->d_bearing / distance;
  if (!result.pixel.allFinite()) return std::nullopt;
  return result;
}

std::optional<PixelBearing> bearing_beside(const Camera& camera, const Eigen::Vector2d& pixel) {
  const LensModel* model = find_lens_model(camera.distortion);
  const Eigen::Vector2d focal(camera.fx, camera.fy);
  const Eigen::Vector2d xy = (pixel - Eigen::Vector2d(camera.cx, camera.cy)).cwiseQuotient(focal);
  if (!model || !model->bearing_of || !xy.allFinite()) return std::nullopt;
  const auto found = model->bearing_of(camera.coefficients, xy);
  if (!found) return std::nullopt;
  const auto bent = model->distort_bearing(camera.coefficients, *found);
  if (!bent) return std::nullopt;
  Eigen::Matrix<double, 3, 2> across;
  across.col(0) = found->unitOrthogonal();
  across.col(1) = found->cross(across.col(0));
  const Eigen::Matrix2d d_across = focal.asDiagonal() * bent->d_bearing * across;
  return PixelBearing{.bearing = *found, .d_pixel = across * d_across.inverse()};
}

}  // namespace

std::optional<PixelProjection> project(const Camera& camera, const Eigen::Vector3d& p_cam) {
  const double z = p_cam.z();
  if (!p_cam.allFinite()) return std::nullopt;
  if (!(z > kMinDepth)) return project_bearing(camera, p_cam);
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

std::optional<PixelBearing> bearing(const Camera& camera, const Eigen::Vector2d& pixel) {
  // Nearly 90 degrees from the axis, the plane loses the digits of its inverse.
  constexpr double kFarthestOnPlane = 1e3;
  const std::optional<PixelRay> forward = unproject(camera, pixel);
  const double length = forward ? forward->ray.norm() : 0;
  if (!forward || length > kFarthestOnPlane) {
    if (auto beside = bearing_beside(camera, pixel); beside || !forward) return beside;
  }
  PixelBearing result{.bearing = forward->ray / length, .d_pixel = {}};
  const Eigen::Matrix3d across =
      Eigen::Matrix3d::Identity() - result.bearing * result.bearing.transpose();
  result.d_pixel = across.leftCols<2>() / length * forward->d_pixel;
  return result;
}

std::optional<ParameterDerivative> parameter_derivative(const Camera& camera,
                                                        const Eigen::Vector3d& p_cam) {
  const std::optional<PixelProjection> seen = project(camera, p_cam);
  if (!seen) return std::nullopt;
  const Eigen::Vector2d focal(camera.fx, camera.fy);
  const Eigen::Vector2d xy =
      (seen->pixel - Eigen::Vector2d(camera.cx, camera.cy)).cwiseQuotient(focal);
  const LensModel& model = *find_lens_model(camera.distortion);
  ParameterDerivative d(2, 4 + static_cast<Eigen::Index>(camera.coefficients.size()));
  d.leftCols<4>() << xy.x(), 0, 1, 0, 0, xy.y(), 0, 1;
  d.rightCols(d.cols() - 4) =
      focal.asDiagonal() * model.by_coefficients(camera.coefficients, p_cam.stableNormalized());
  return d;
}

Eigen::Vector2d focal_lengths_at_axis(const Camera& camera) {
  const LensModel* model = find_lens_model(camera.distortion);
  const double slope = model && model->axis_slope ? model->axis_slope(camera.coefficients) : 1;
  return {camera.fx * slope, camera.fy * slope};
}

bool sees_beside(const Camera& camera) {
  const LensModel* model = find_lens_model(camera.distortion);
  return model != nullptr && model->distort_bearing != nullptr;
}

bool is_ahead(const Eigen::Vector3d& p_cam) {
  constexpr double kLeastCosine = 0.17364817766693033;  // of 80 degrees
  return p_cam.z() > kLeastCosine * p_cam.norm();
}

std::optional<WideRay> wide_ray(const Camera& camera, const Eigen::Vector2d& pixel) {
  if (const auto forward = unproject(camera, pixel); forward && is_ahead(forward->ray)) {
    WideRay result{.ray = forward->ray, .d_pixel = {}};
    result.d_pixel << forward->d_pixel, Eigen::RowVector2d::Zero();
    return result;
  }
  const auto beside = bearing(camera, pixel);
  if (!beside) return std::nullopt;
  return WideRay{.ray = beside->bearing, .d_pixel = beside->d_pixel};
}

bool in_image(const Camera& camera, const Eigen::Vector2d& pixel, double border) {
  return pixel.x() >= border && pixel.x() <= camera.width - 1 - border &&  //
         pixel.y() >= border && pixel.y() <= camera.height - 1 - border;
}

}  // namespace chasles
