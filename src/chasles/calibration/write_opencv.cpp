#include <array>

#include <fmt/format.h>

#include <chasles/calibration/writing.hpp>

namespace chasles {
namespace {

struct OpencvLens {
  const char* model;
  std::vector<double> coefficients;
  std::optional<double> xi = {};
};

OpencvLens opencv_lens(const Camera& camera, std::size_t index) {
  std::vector<double> stated = stated_coefficients(camera);
  switch (camera.distortion) {
    case Distortion::kNone:
      return {"pinhole", std::vector<double>(4)};
    case Distortion::kRadtan:
      return {"pinhole", std::move(stated)};
    case Distortion::kEquidistant:
      return {"fisheye", std::move(stated)};
    case Distortion::kOmni: {
      std::vector<double> further(stated.begin() + 1, stated.end());
      further.resize(4);
      return {"omnidir", std::move(further), stated.front()};
    }
    default:
      no_such_lens(index, camera, "OpenCV", "none, radtan, equidistant or omni");
  }
}

std::string opencv_matrix_text(const char* name, std::size_t rows, std::span<const double> values) {
  return fmt::format("{}: !!opencv-matrix\n   rows: {}\n   cols: {}\n   dt: d\n   data: {}\n", name,
                     rows, values.size() / rows, pointed_list(values));
}

std::string motion_matrices(const SE3& motion, const char* rotation, const char* translation) {
  const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> R = motion.R;
  return opencv_matrix_text(rotation, 3, {R.data(), 9}) +
         opencv_matrix_text(translation, 3, {motion.p.data(), 3});
}

std::string opencv_remark(const CalibrationToWrite& calibration) {
  return std::string(
             "OpenCV's FileStorage. model: the functions that take cameraMatrix and "
             "distCoeffs, namely\n"
             "cv::projectPoints (pinhole), cv::fisheye (fisheye) or cv::omnidir (omnidir, "
             "with xi).\n"
             "Pixels: the centre of the first one is (0, 0).\n"
             "R and T [m] map the first camera's coordinates to those of this one:\n"
             "p_cam = R * p_cam0 + T, as those of cv::stereoCalibrate.\n") +
         (calibration.has_imu ? "R_imu and T_imu map those of the IMU: p_cam = R_imu * p_imu + "
                                "T_imu.\ntime_offset [s]: clock of the IMU = clock of the camera + "
                                "time_offset.\n"
                              : "");
}

std::string opencv_text(const CalibrationToWrite& calibration, std::size_t index) {
  const Camera& c = calibration.cameras[index];
  const OpencvLens lens = opencv_lens(c, index);
  std::string text = "%YAML:1.0\n---\n" + as_comment(calibration, opencv_remark(calibration)) +
                     fmt::format("image_width: {}\nimage_height: {}\nmodel: \"{}\"\n", c.width,
                                 c.height, lens.model) +
                     opencv_matrix_text("cameraMatrix", 3,
                                        std::array{c.fx, 0., c.cx, 0., c.fy, c.cy, 0., 0., 1.}) +
                     opencv_matrix_text("distCoeffs", lens.coefficients.size(), lens.coefficients);
  if (lens.xi) text += fmt::format("xi: {}\n", pointed(*lens.xi));
  const SE3 first_T_imu = calibration.cameras.front().cam_T_imu;
  text += motion_matrices(index == 0 ? SE3{} : c.cam_T_imu * first_T_imu.inverse(), "R", "T");
  if (!calibration.has_imu) return text;
  return text + motion_matrices(c.cam_T_imu, "R_imu", "T_imu") +
         fmt::format("time_offset: {}\n", pointed(time_offset_of(calibration, index)));
}

}  // namespace

CalibrationFiles opencv_files(const CalibrationToWrite& calibration) {
  CalibrationFiles result{.left_out =
                              without_room(calibration, "OpenCV's file", {.time_offsets = true})};
  for (std::size_t c = 0; c < calibration.cameras.size(); ++c) {
    result.files.push_back({fmt::format("opencv/cam{}.yaml", c), opencv_text(calibration, c)});
  }
  return result;
}

}  // namespace chasles
