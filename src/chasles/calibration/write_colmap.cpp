#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/colmap_lens.hpp>
#include <chasles/calibration/writing.hpp>
#include <chasles/codec/numbers.hpp>

namespace chasles {
namespace {

std::string colmap_remark(const CalibrationToWrite& calibration) {
  std::string text =
      "COLMAP's cameras.txt. Pixels: the centre of the first one is (0.5, 0.5), so that cx and cy\n"
      "are 0.5 more than those of OpenCV, ROS and Kalibr. It has no place for where the cameras\n"
      "are, nor for an IMU.\n";
  if (calibration.cameras.size() > 1) {
    text += "camN_from_cam1 as QW QX QY QZ TX TY TZ [m], with COLMAP's ids:\n";
  }
  for (std::size_t c = 1; c < calibration.cameras.size(); ++c) {
    const SE3 cam_T_first =
        calibration.cameras[c].cam_T_imu * calibration.cameras.front().cam_T_imu.inverse();
    const Eigen::Vector4d q = unit_quaternion(cam_T_first.R);
    text += fmt::format("cam{}_from_cam1: {} {} {} {} {} {} {}\n", c + 1, q[3], q[0], q[1], q[2],
                        cam_T_first.p.x(), cam_T_first.p.y(), cam_T_first.p.z());
  }
  return text;
}

}  // namespace

CalibrationFiles colmap_files(const CalibrationToWrite& calibration) {
  return {.files = {{"colmap/cameras.txt", as_comment(calibration, colmap_remark(calibration)) +
                                               colmap_camera_lines(calibration.cameras)}},
          .left_out = without_room(calibration, "COLMAP's cameras.txt", {})};
}

}  // namespace chasles
