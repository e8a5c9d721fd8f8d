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

double line_delay(const Camera& camera, const Eigen::Vector2d& pixel) {
  const double along_columns = pixel.x() / camera.width, along_rows = pixel.y() / camera.height;
  switch (camera.shutter.direction) {
    case ReadoutDirection::kDown:
      return camera.shutter.readout * along_rows;
    case ReadoutDirection::kUp:
      return camera.shutter.readout * (1 - 1.0 / camera.height - along_rows);
    case ReadoutDirection::kRight:
      return camera.shutter.readout * along_columns;
    case ReadoutDirection::kLeft:
      return camera.shutter.readout * (1 - 1.0 / camera.width - along_columns);
  }
  return 0;
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
