#include <algorithm>
#include <array>

#include <fmt/format.h>

#include <chasles/calibration/writing.hpp>
#include <chasles/codec/numbers.hpp>

namespace chasles {
namespace {

struct RosLens {
  const char* model;
  std::vector<double> coefficients;
};

// The three models of sensor_msgs/distortion_models.hpp. Rectified images are a plumb_bob of zeros.
RosLens ros_lens(const Camera& camera, std::size_t index) {
  constexpr std::size_t kPlumbBob = 5, kRational = 8;
  std::vector<double> stated = stated_coefficients(camera);
  const bool pinhole =
      camera.distortion == Distortion::kNone || camera.distortion == Distortion::kRadtan;
  if (pinhole && stated.size() <= kRational) {
    const bool rational = stated.size() > kPlumbBob;
    stated.resize(rational ? kRational : kPlumbBob);
    return {rational ? "rational_polynomial" : "plumb_bob", std::move(stated)};
  }
  if (camera.distortion == Distortion::kEquidistant) return {"equidistant", std::move(stated)};
  no_such_lens(index, camera, "ROS's CameraInfo",
               "none, radtan with at most 8 coefficients, or equidistant");
}

std::string ros_matrix(const char* name, std::size_t rows, std::span<const double> values) {
  return fmt::format("{}:\n  rows: {}\n  cols: {}\n  data: {}\n", name, rows, values.size() / rows,
                     pointed_list(values));
}

std::string ros_remark(const CalibrationToWrite& calibration, std::size_t index) {
  const Camera& camera = calibration.cameras[index];
  const SE3 parent_T_cam = camera.cam_T_imu.inverse();
  const Eigen::Vector4d q = unit_quaternion(parent_T_cam.R);
  return fmt::format(
      "sensor_msgs/CameraInfo. Pixels: the centre of the first one is (0, 0). The images are not\n"
      "rectified: rectification_matrix is the identity, and projection_matrix has camera_matrix.\n"
      "It has no place for where the camera is, nor for its clock. A static transform with the\n"
      "parent {0} and the child cam{1} (p_{0} = {0}_T_cam{1} * p_cam{1}) has\n"
      "translation x y z [m]: {2} {3} {4}\nquaternion x y z w: {5} {6} {7} {8}\n{9}",
      calibration.has_imu ? "imu" : "cam0", index, parent_T_cam.p.x(), parent_T_cam.p.y(),
      parent_T_cam.p.z(), q[0], q[1], q[2], q[3],
      calibration.has_imu ? fmt::format("clock of the IMU = clock of the camera + {} s\n",
                                        time_offset_of(calibration, index))
                          : "");
}

std::string ros_text(const CalibrationToWrite& calibration, std::size_t index) {
  const Camera& c = calibration.cameras[index];
  const RosLens lens = ros_lens(c, index);
  return as_comment(calibration, ros_remark(calibration, index)) +
         fmt::format("image_width: {}\nimage_height: {}\ncamera_name: cam{}\n", c.width, c.height,
                     index) +
         ros_matrix("camera_matrix", 3, std::array{c.fx, 0., c.cx, 0., c.fy, c.cy, 0., 0., 1.}) +
         fmt::format("distortion_model: {}\n", lens.model) +
         ros_matrix("distortion_coefficients", 1, lens.coefficients) +
         ros_matrix("rectification_matrix", 3, std::array{1., 0., 0., 0., 1., 0., 0., 0., 1.}) +
         ros_matrix("projection_matrix", 3,
                    std::array{c.fx, 0., c.cx, 0., 0., c.fy, c.cy, 0., 0., 0., 1., 0.});
}

}  // namespace

CalibrationFiles ros_files(const CalibrationToWrite& calibration) {
  CalibrationFiles result{.left_out = without_room(calibration, "ROS's CameraInfo", {})};
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    result.files.push_back({fmt::format("ros/cam{}.yaml", c), ros_text(calibration, c)});
  }
  return result;
}

}  // namespace chasles
