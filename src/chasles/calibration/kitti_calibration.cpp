#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/kitti_calibration.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/parse.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {

KittiCalibration::KittiCalibration(const std::filesystem::path& file) : file_(file.string()) {
  const std::string bytes = read_text(file);
  std::string_view rest = bytes;
  while (!rest.empty()) {
    const std::string_view line = take_line(rest);
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos) continue;
    rows_[std::string(trimmed(line.substr(0, colon)))] = std::string(line.substr(colon + 1));
  }
}

Eigen::VectorXd KittiCalibration::numbers(const std::string& key, std::size_t size) const {
  const auto row = rows_.find(key);
  if (row == rows_.end()) throw InputError(where(key) + ": is missing");
  const auto words = split_words(row->second);
  if (words.size() != size) {
    throw InputError(
        fmt::format("{}: holds {} numbers, expected {}", where(key), words.size(), size));
  }
  Eigen::VectorXd values(static_cast<Eigen::Index>(size));
  for (std::size_t i = 0; i < size; ++i) {
    values[static_cast<Eigen::Index>(i)] = parse_finite(where(key), words[i]);
  }
  return values;
}

Eigen::Matrix3d KittiCalibration::rotation(const std::string& key) const {
  return checked_rotation(where(key),
                          Eigen::Matrix3d(numbers(key, 9).reshaped<Eigen::RowMajor>(3, 3)));
}

KittiProjection kitti_projection(const KittiCalibration& calibration, const std::string& key) {
  const Eigen::VectorXd P = calibration.numbers(key, 12);
  KittiProjection result{.fx = checked_positive(calibration.where(key), P[0]),
                         .fy = checked_positive(calibration.where(key), P[5]),
                         .cx = P[2],
                         .cy = P[6],
                         .t = {}};
  result.t = {(P[3] - result.cx * P[11]) / result.fx, (P[7] - result.cy * P[11]) / result.fy,
              P[11]};
  return result;
}

}  // namespace chasles
