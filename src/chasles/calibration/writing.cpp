#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/writing.hpp>

namespace chasles {

std::string pointed(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find('.') == std::string::npos) text.insert(std::min(text.find('e'), text.size()), ".0");
  return text;
}

std::string pointed_list(std::span<const double> values) {
  std::vector<std::string> texts;
  for (const double value : values) texts.push_back(pointed(value));
  return fmt::format("[{}]", fmt::join(texts, ", "));
}

std::string pointed_motion(const SE3& motion, const std::string& indent) {
  std::string text;
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector4d row(motion.R(i, 0), motion.R(i, 1), motion.R(i, 2), motion.p(i));
    text += fmt::format("{}- {}\n", indent, pointed_list({row.data(), 4}));
  }
  return text + indent + "- [0.0, 0.0, 0.0, 1.0]\n";
}

std::string as_comment(const CalibrationToWrite& calibration, const std::string& lines) {
  std::string all = calibration.remark + "\n" + lines, text;
  std::erase(all, '\r');  // some readers end a line there
  for (std::size_t at = 0; at < all.size();) {
    const std::size_t end = std::min(all.find('\n', at), all.size());
    if (end > at) text += "# " + all.substr(at, end - at) + "\n";
    at = end + 1;
  }
  return text;
}

double time_offset_of(const CalibrationToWrite& calibration, std::size_t camera) {
  return calibration.time_offsets.empty() ? 0 : calibration.time_offsets[camera];
}

std::vector<double> stated_coefficients(const Camera& camera) {
  const std::span<const double> stated = without_padding(camera.distortion, camera.coefficients);
  return {stated.begin(), stated.end()};
}

void no_such_lens(std::size_t camera, const Camera& lens, const std::string& format,
                  const std::string& lenses) {
  throw InputError(fmt::format(
      "cam{}: {} has no lens model {} with {} coefficients, expected {}: calibrate "
      "with one of these",
      camera, format, name_of(lens.distortion), stated_coefficients(lens).size(), lenses));
}

std::vector<std::string> without_room(const CalibrationToWrite& calibration,
                                      const std::string& format, const FormatRoom& room) {
  std::vector<std::string> names;
  const auto lacks = [&](bool has_room, bool stated, const char* name) {
    if (!has_room && stated) names.emplace_back(name);
  };
  const auto& offsets = calibration.time_offsets;
  lacks(room.time_offsets, std::ranges::any_of(offsets, [](double s) { return s != 0; }),
        "time offset");
  lacks(room.shutter,
        std::ranges::any_of(calibration.cameras,
                            [](const Camera& c) { return c.shutter.is_rolling(); }),
        "readout time");
  lacks(room.imu_intrinsics, calibration.imu_intrinsics.has_value(), "intrinsics of an IMU");
  if (names.empty()) return {};
  return {fmt::format("{} has no {}", format, fmt::join(names, ", no "))};
}

}  // namespace chasles
