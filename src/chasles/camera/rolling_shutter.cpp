#include <cmath>

#include <chasles/camera/camera.hpp>
#include <chasles/camera/rolling_shutter.hpp>
#include <chasles/lie/so3.hpp>

namespace chasles {

void set_readout(double seconds, std::span<Camera> cameras) {
  for (Camera& camera : cameras) {
    camera.shutter.readout = std::abs(seconds);
    if (seconds < 0) camera.shutter.direction = ReadoutDirection::kUp;
  }
}

double line_part(const Camera& camera, const Eigen::Vector2d& pixel) {
  const double column = pixel.x() / camera.width, row = pixel.y() / camera.height;
  switch (camera.shutter.direction) {
    case ReadoutDirection::kDown:
      return row;
    case ReadoutDirection::kUp:
      return 1 - 1.0 / camera.height - row;
    case ReadoutDirection::kRight:
      return column;
    case ReadoutDirection::kLeft:
      return 1 - 1.0 / camera.width - column;
  }
  return 0;
}

double line_delay(const Camera& camera, const Eigen::Vector2d& pixel) {
  return camera.shutter.readout * line_part(camera, pixel);
}

SE3 ReadoutMotion::after(double seconds) const {
  const double square = seconds * seconds;
  return {.R = so3::exp(rate * seconds + rate_change * square),
          .p = velocity * seconds + acceleration * square};
}

SE3 imu_T_line(const Camera& camera, const ReadoutMotion& motion, const Eigen::Vector2d& pixel) {
  if (!camera.shutter.is_rolling()) return {};
  return motion.after(line_delay(camera, pixel));
}

Camera at_line(Camera camera, const ReadoutMotion& motion, const Eigen::Vector2d& pixel) {
  if (!camera.shutter.is_rolling()) return camera;
  camera.cam_T_imu = camera.cam_T_imu * imu_T_line(camera, motion, pixel).inverse();
  return camera;
}

}  // namespace chasles
