#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <chasles/calibration/calibration.hpp>
#include <chasles/calibration/imu_noise.hpp>
#include <chasles/calibration/imu_range.hpp>
#include <chasles/calibration/shutter.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/utf8.hpp>

namespace chasles {
namespace {

template <typename Values>
std::string listed(const Values& values) {
  return fmt::format("[{}]", fmt::join(values.begin(), values.end(), ", "));
}

std::string quoted(const std::string& text) { return json_text(text); }

std::string motion_text(const SE3& T, const std::string& indent) {
  std::string text;
  for (int i = 0; i < 3; ++i) {
    text += fmt::format("{}- [{}, {}, {}, {}]\n", indent, T.R(i, 0), T.R(i, 1), T.R(i, 2), T.p(i));
  }
  return text + indent + "- [0, 0, 0, 1]\n";
}

std::string rig_text(const StereoRig& rig) {
  return fmt::format(
             "# Rectified stereo pair: focal lengths and principal point of both cameras [px].\n"
             "fx: {}\nfy: {}\ncx: {}\ncy: {}\n"
             "# The right camera lies this far along the left camera's x axis [m].\n"
             "baseline: {}\n"
             "# Maps IMU coordinates to those of the left camera [m]: p_cam0 = cam0_T_imu * "
             "p_imu.\n"
             "# imu: x forward, y left, z up on a car. cam0: x right, y down, z forward.\n"
             "cam0_T_imu:\n",
             rig.fx, rig.fy, rig.cx, rig.cy, rig.baseline) +
         motion_text(rig.cam0_T_imu, "  ");
}

std::string time_offset_text(Time offset) {
  if (offset == Time::zero()) return {};
  return fmt::format(
      "    # Added to the stamps of the images, it gives the IMU's clock [s].\n"
      "    timeshift_cam_imu: {}\n",
      to_seconds(offset));
}

std::string cameras_text(const FolderCalibration& calibration) {
  std::string text =
      "# Single cameras. intrinsics: fx, fy, cx, cy [px]. distortion: radtan k1, k2, p1, p2, k3;\n"
      "# equidistant k1 to k4. cam_T_imu maps IMU coordinates to those of the camera [m].\n"
      "cameras:\n";
  for (std::size_t i = 0; i < calibration.cameras.size(); ++i) {
    const Camera& c = calibration.cameras[i];
    text += fmt::format(
        "  - resolution: [{}, {}]\n    intrinsics: {}\n    distortion_model: {}\n"
        "    distortion_coeffs: {}\n    cam_T_imu:\n",
        c.width, c.height, listed(Eigen::Vector4d(c.fx, c.fy, c.cx, c.cy)), name_of(c.distortion),
        c.distortion == Distortion::kNone ? "[0, 0, 0, 0]" : listed(c.coefficients));
    text += motion_text(c.cam_T_imu, "      ");
    if (!calibration.time_offsets.empty()) text += time_offset_text(calibration.time_offsets[i]);
    text += shutter_text(c.shutter, "    ");
  }
  return text;
}

std::string imu_text(const FolderCalibration& calibration) {
  std::string text = fmt::format(
      "# An IMU sample is the value at its time (instant), the mean since the sample before\n"
      "# (interval-mean), or the force of the former and the rate of the latter (instant-force).\n"
      "imu_convention: {}\n",
      name_of(*calibration.imu_convention));
  text += imu_range_text(calibration.imu_range);
  if (!calibration.imu_noise) return text;
  const ImuNoise& noise = *calibration.imu_noise;
  return text +
         fmt::format(
             "# White noise [m/s^2/sqrt(Hz)], [rad/s/sqrt(Hz)], and the biases' random\n"
             "# walks [m/s^3/sqrt(Hz)], [rad/s^2/sqrt(Hz)].\n"
             "accelerometer_noise_density: {}\naccelerometer_random_walk: {}\n"
             "gyroscope_noise_density: {}\ngyroscope_random_walk: {}\n",
             noise.accelerometer_noise_density, noise.accelerometer_random_walk,
             noise.gyroscope_noise_density, noise.gyroscope_random_walk) +
         noise_is_exact_text(noise);
}

std::string stated_noise_text(const FolderCalibration& calibration) {
  std::string text;
  if (calibration.velocity_sigma) {
    text += fmt::format(
        "# White noise of a velocity sample, standard deviations [m/s], [rad/s].\n"
        "linear_sigma: {}\nangular_sigma: {}\n",
        listed(calibration.velocity_sigma->linear), listed(calibration.velocity_sigma->angular));
  }
  if (calibration.pixel_sigma) {
    text += fmt::format(
        "# White noise of (uL, vL, uR, vR), standard deviations [px].\npixel_sigma: {}\n",
        listed(*calibration.pixel_sigma));
  }
  if (calibration.single_pixel_sigma) {
    text += fmt::format(
        "# White noise of u and of v in a single camera, standard deviation [px].\n"
        "single_pixel_sigma: {}\n",
        *calibration.single_pixel_sigma);
  }
  return text;
}

}  // namespace

std::string calibration_text(const FolderCalibration& calibration) {
  std::string text =
      fmt::format("# A recording (docs/formats.md).\nformat: chasles-recording-1\nname: {}\n",
                  quoted(calibration.name));
  if (calibration.rig) text += rig_text(*calibration.rig);
  if (!calibration.cameras.empty()) text += cameras_text(calibration);
  if (calibration.imu_convention) text += imu_text(calibration);
  text += stated_noise_text(calibration);
  if (calibration.truth_level) {
    text += fmt::format("# Whether the z axis of the truth's world points up.\ntruth_level: {}\n",
                        *calibration.truth_level);
  }
  if (!calibration.remarks.empty()) text += "# What was corrected, dropped or counted.\nremarks:\n";
  for (const std::string& remark : calibration.remarks) {
    text += fmt::format("  - {}\n", quoted(remark));
  }
  return text;
}

void write_calibration(const FolderCalibration& calibration, const std::filesystem::path& file) {
  write_file(file, calibration_text(calibration));
}

}  // namespace chasles
