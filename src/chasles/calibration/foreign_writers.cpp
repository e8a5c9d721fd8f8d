#include <array>
#include <cmath>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/base/time.hpp>
#include <chasles/calibration/calibration.hpp>
#include <chasles/calibration/writing.hpp>
#include <chasles/codec/durable_file.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

struct WrittenFormat {
  const char* name;
  CalibrationFiles (*files)(const CalibrationToWrite&);
};

constexpr std::array kWrittenFormats{WrittenFormat{"Chasles", &own_calibration_files},
                                     WrittenFormat{"Kalibr", &kalibr_files},
                                     WrittenFormat{"ROS", &ros_files},
                                     WrittenFormat{"OpenCV", &opencv_files},
                                     WrittenFormat{"Basalt", &basalt_files},
                                     WrittenFormat{"COLMAP", &colmap_files}};

bool is_finite(const Camera& c) {
  return std::isfinite(c.fx + c.fy + c.cx + c.cy) && c.coefficients.is_finite() &&
         c.cam_T_imu.R.allFinite() && c.cam_T_imu.p.allFinite();
}

bool is_finite(const ImuNoise& n) {
  return std::isfinite(n.accelerometer_noise_density + n.accelerometer_random_walk +
                       n.gyroscope_noise_density + n.gyroscope_random_walk);
}

void check_to_write(const CalibrationToWrite& calibration) {
  const std::string& name = calibration.name;
  const std::size_t cameras = calibration.cameras.size(), offsets = calibration.time_offsets.size();
  if (cameras == 0) {
    throw InputError(fmt::format("{}: the calibration has no cameras, expected one", name));
  }
  if (offsets != 0 && offsets != cameras) {
    throw InputError(fmt::format("{}: found {} time offsets, expected one for each of {} cameras",
                                 name, offsets, cameras));
  }
  const auto diverged = [&](const std::string& what) {
    throw InputError(
        fmt::format("{}: {} has a number that is not finite, expected a calibration that converged",
                    name, what));
  };
  for (std::size_t c = 0; c < cameras; ++c) {
    const bool finite = is_finite(calibration.cameras[c]);
    if (!finite || !std::isfinite(time_offset_of(calibration, c)))
      diverged(fmt::format("cam{}", c));
  }
  if (calibration.imu_noise && !is_finite(*calibration.imu_noise)) diverged("the noise of the IMU");
}

}  // namespace

CalibrationFiles own_calibration_files(const CalibrationToWrite& calibration) {
  FolderCalibration own{.name = calibration.name,
                        .cameras = calibration.cameras,
                        .imu_noise = calibration.imu_noise,
                        .imu_range = calibration.imu_range};
  for (const double offset : calibration.time_offsets) {
    own.time_offsets.push_back(from_seconds(offset));
  }
  if (calibration.has_imu) own.imu_convention = calibration.imu_convention;
  if (!calibration.remark.empty()) own.remarks.push_back(calibration.remark);
  return {
      .files = {{"calibration.yaml", calibration_text(own)}},
      .left_out = without_room(calibration, "calibration.yaml",
                               {.time_offsets = true, .shutter = true, .imu_intrinsics = false})};
}

WrittenCalibration write_all(const CalibrationToWrite& calibration, const fs::path& folder) {
  check_to_write(calibration);
  WrittenCalibration written;
  for (const WrittenFormat& format : kWrittenFormats) {
    try {
      const CalibrationFiles made = format.files(calibration);
      for (const CalibrationFile& file : made.files) {
        const fs::path path = folder / file.name;
        make_folder(path.parent_path());
        replace_file(path, file.text);
        written.files.push_back(path);
      }
      written.left_out.insert(written.left_out.end(), made.left_out.begin(), made.left_out.end());
    } catch (const InputError& error) {
      written.left_out.push_back(
          fmt::format("{}'s file is not written: {}", format.name, error.what()));
    }
  }
  return written;
}

}  // namespace chasles
