#include <chasles/camera/stereo.hpp>

namespace chasles {

std::optional<StereoProjection> project(const StereoRig& rig, const Eigen::Vector3d& p_cam0) {
  const double z = p_cam0.z();
  if (!(z > kMinDepth)) return std::nullopt;
  const double x = p_cam0.x() / z;
  const double y = p_cam0.y() / z;
  const double disparity = rig.fx * rig.baseline / z;
  const double u = rig.fx * x + rig.cx;
  const double v = rig.fy * y + rig.cy;
  StereoProjection result;
  result.pixels << u, v, u - disparity, v;
  result.d_point << rig.fx / z, 0, -rig.fx * x / z,  //
      0, rig.fy / z, -rig.fy * y / z,                //
      rig.fx / z, 0, (disparity - rig.fx * x) / z,   //
      0, rig.fy / z, -rig.fy * y / z;
  return result;
}

std::optional<StereoPoint> triangulate(const StereoRig& rig, const Eigen::Vector4d& pixels) {
  const double disparity = pixels[0] - pixels[2];
  if (!(disparity > 0)) return std::nullopt;
  const double z = rig.fx * rig.baseline / disparity;
  const Eigen::Vector3d ray((pixels[0] - rig.cx) / rig.fx,
                            ((pixels[1] + pixels[3]) / 2 - rig.cy) / rig.fy, 1);
  const Eigen::Vector3d d_disparity = -z / disparity * ray;
  StereoPoint result;
  result.p_cam0 = z * ray;
  result.d_pixels.col(0) = d_disparity + Eigen::Vector3d(z / rig.fx, 0, 0);
  result.d_pixels.col(1) = Eigen::Vector3d(0, z / (2 * rig.fy), 0);
  result.d_pixels.col(2) = -d_disparity;
  result.d_pixels.col(3) = result.d_pixels.col(1);
  return result;
}

}  // namespace chasles
