#include <chasles/camera/anchor_face.hpp>

namespace chasles {

AnchorFace face_towards(const Eigen::Vector3d& p_cam) {
  if (is_ahead(p_cam)) return AnchorFace::kFront;
  Eigen::Index axis = 0;
  p_cam.cwiseAbs().maxCoeff(&axis);
  const bool positive = p_cam[axis] > 0;
  if (axis == 0) return positive ? AnchorFace::kRight : AnchorFace::kLeft;
  if (axis == 1) return positive ? AnchorFace::kDown : AnchorFace::kUp;
  return AnchorFace::kBack;
}

Eigen::Matrix3d face_R_cam(AnchorFace face) {
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  switch (face) {
    case AnchorFace::kFront:
      break;
    case AnchorFace::kRight:
      R << 0, 0, -1, 0, 1, 0, 1, 0, 0;
      break;
    case AnchorFace::kLeft:
      R << 0, 0, 1, 0, 1, 0, -1, 0, 0;
      break;
    case AnchorFace::kDown:
      R << 1, 0, 0, 0, 0, -1, 0, 1, 0;
      break;
    case AnchorFace::kUp:
      R << 1, 0, 0, 0, 0, 1, 0, -1, 0;
      break;
    case AnchorFace::kBack:
      R << -1, 0, 0, 0, 1, 0, 0, 0, -1;
      break;
  }
  return R;
}

SE3 face_T_imu(AnchorFace face, const SE3& cam_T_imu) {
  if (face == AnchorFace::kFront) return cam_T_imu;
  const Eigen::Matrix3d R = face_R_cam(face);
  return {R * cam_T_imu.R, R * cam_T_imu.p};
}

Eigen::Vector3d inverse_depth_in(AnchorFace face, const Eigen::Vector3d& p_cam, double w) {
  const Eigen::Vector3d p = face_R_cam(face) * p_cam;
  return Eigen::Vector3d(p.x(), p.y(), w) / p.z();
}

std::optional<FaceRay> face_ray(const Camera& camera, const Eigen::Vector2d& pixel) {
  const std::optional<WideRay> seen = wide_ray(camera, pixel);
  if (!seen) return std::nullopt;
  FaceRay result;
  result.face = face_towards(seen->ray);
  const Eigen::Matrix3d R = face_R_cam(result.face);
  const Eigen::Vector3d ray = R * seen->ray;
  const Eigen::Matrix<double, 3, 2> d_ray = R * seen->d_pixel;
  result.xy = ray.head<2>() / ray.z();
  result.d_pixel = (d_ray.topRows<2>() - result.xy * d_ray.row(2)) / ray.z();
  return result;
}

}  // namespace chasles
