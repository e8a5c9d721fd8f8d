#pragma once

#include <cstdint>
#include <optional>

#include <Eigen/Core>

#include <chasles/camera/camera.hpp>

namespace chasles {

/// The axes of an anchored landmark's inverse depth, (x/z, y/z, 1/z). Its rays must be well off the
/// plane z = 0. So directions beyond 80 degrees from a camera's axis have the axes of another face
/// of the cube about the camera, whose z axis points out of that face. A face is at most 55 degrees
/// off its directions, and as it turns the axes by right angles, no digit is lost.
enum class AnchorFace : std::uint8_t { kFront, kRight, kLeft, kDown, kUp, kBack };

/// The number of faces.
inline constexpr int kAnchorFaces = 6;

/// The face of a direction or point in the camera's frame.
AnchorFace face_towards(const Eigen::Vector3d& p_cam);

/// Maps the camera's axes to those of the face; the identity for the front.
Eigen::Matrix3d face_R_cam(AnchorFace face);

/// Maps IMU coordinates to those of the face, whose origin is the camera's.
SE3 face_T_imu(AnchorFace face, const SE3& cam_T_imu);

/// The inverse depth [1, 1, 1/m] of the point p_cam / w in the axes of the face.
Eigen::Vector3d inverse_depth_in(AnchorFace face, const Eigen::Vector3d& p_cam, double w);

/// The ray of a pixel in the axes of its face.
struct FaceRay {
  AnchorFace face = AnchorFace::kFront;
  Eigen::Vector2d xy;       ///< (x/z, y/z)
  Eigen::Matrix2d d_pixel;  ///< d xy / d pixel  [1/px]
};

/// None outside the range of the lens model.
std::optional<FaceRay> face_ray(const Camera& camera, const Eigen::Vector2d& pixel);

}  // namespace chasles
