#pragma once

#include <array>
#include <span>

#include <Eigen/Core>

#include <chasles/base/settings.hpp>
#include <chasles/lie/se3.hpp>

namespace chasles {

struct Camera;

/// In which order a sensor is read, in the image as it is stored.
enum class ReadoutDirection { kDown, kUp, kRight, kLeft };

template <>
struct Choices<ReadoutDirection> {
  static constexpr std::array list{
      Choice{ReadoutDirection::kDown, "down"}, Choice{ReadoutDirection::kUp, "up"},
      Choice{ReadoutDirection::kRight, "right"}, Choice{ReadoutDirection::kLeft, "left"}};
};

/// How a sensor is exposed. With a rolling shutter its lines are exposed one after the other: the
/// time of an image is that of the first line, and the last one follows almost `readout` later.
struct Shutter {
  double readout = 0;  ///< time between two lines, times their number [s]; 0: a global shutter
  ReadoutDirection direction = ReadoutDirection::kDown;

  bool is_rolling() const { return readout > 0; }
};

/// Longer readouts are rejected: no sensor needs more [s].
inline constexpr double kLongestReadout = 0.2;

/// Sets the readout of all cameras [s], in the direction that they have; upwards below 0.
void set_readout(double seconds, std::span<Camera> cameras);

/// The part of the readout after which the line of a pixel was exposed, 0 to 1 within the image.
double line_part(const Camera& camera, const Eigen::Vector2d& pixel);
/// When that was, after the time of its image [s].
double line_delay(const Camera& camera, const Eigen::Vector2d& pixel);

/// The motion of an IMU while a sensor is read out, in the IMU's axes at the time of the image:
/// R = Exp(rate t + rate_change t^2), p = velocity t + acceleration t^2.
struct ReadoutMotion {
  Eigen::Vector3d rate = Eigen::Vector3d::Zero();          ///< [rad/s]
  Eigen::Vector3d rate_change = Eigen::Vector3d::Zero();   ///< [rad/s^2]
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();      ///< [m/s]
  Eigen::Vector3d acceleration = Eigen::Vector3d::Zero();  ///< half of it [m/s^2]

  /// imu_T_later: maps the IMU's coordinates at a later time [s] to those at the time of the image.
  SE3 after(double seconds) const;
};

/// imu_T_line: maps the IMU's coordinates when the pixel's line was exposed to those at the time of
/// the image. The identity with a global shutter.
SE3 imu_T_line(const Camera& camera, const ReadoutMotion& motion, const Eigen::Vector2d& pixel);

/// The camera with its extrinsics when the pixel's line was exposed, against the IMU at the time of
/// the image. Unchanged with a global shutter.
Camera at_line(Camera camera, const ReadoutMotion& motion, const Eigen::Vector2d& pixel);

}  // namespace chasles
