#include <algorithm>
#include <array>
#include <optional>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/foreign_calibration.hpp>
#include <chasles/codec/text_file.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

enum class ForeignKind { kVins, kOrb, kBasalt, kDepthai };

struct ForeignFile {
  fs::path file;
  ForeignKind kind;
};

// Whether a line of YAML begins with this key.
bool has_key(const std::string& text, const std::string& key) {
  return text.find("\n" + key + ":") != std::string::npos || text.starts_with(key + ":");
}

std::optional<ForeignKind> kind_of_yaml(const std::string& text) {
  if (has_key(text, "body_T_cam0") || has_key(text, "extrinsicRotation") ||
      (has_key(text, "cam0_calib") && has_key(text, "imu_topic"))) {
    return ForeignKind::kVins;
  }
  const auto has = [&](const char* key) { return has_key(text, key); };
  const bool orb = std::ranges::any_of(
      std::array{"Camera1.fx", "Camera.fx", "LEFT.K", "IMU.T_b_c1", "IMU.NoiseGyro"}, has);
  return orb ? std::optional(ForeignKind::kOrb) : std::nullopt;
}

std::optional<ForeignKind> kind_of_json(const std::string& text) {
  const auto holds = [&](const char* key) { return text.find(key) != std::string::npos; };
  if (holds("\"value0\"") && holds("\"T_imu_cam\"")) return ForeignKind::kBasalt;
  if (holds("\"cameraData\"")) return ForeignKind::kDepthai;
  return std::nullopt;
}

std::optional<ForeignKind> kind_of_file(const fs::path& file) {
  constexpr std::uintmax_t kLargest = 4'000'000;  // no calibration is larger
  const std::string ending = lower_case(file.extension().string());
  const bool yaml = ending == ".yaml" || ending == ".yml", json = ending == ".json";
  std::error_code error;
  if ((!yaml && !json) || file.filename().string().starts_with(".")) return std::nullopt;
  if (!fs::is_regular_file(file, error) || fs::file_size(file, error) > kLargest) {
    return std::nullopt;
  }
  const std::string text = read_text(file);
  return yaml ? kind_of_yaml(text) : kind_of_json(text);
}

std::vector<ForeignFile> foreign_files(const fs::path& folder) {
  std::vector<ForeignFile> found;
  std::error_code ignored;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, ignored)) {
    if (const auto kind = kind_of_file(entry.path())) found.push_back({entry.path(), *kind});
  }
  std::ranges::sort(found, {}, &ForeignFile::file);
  return found;
}

KalibrCalibration read_foreign(const ForeignFile& found, std::size_t cameras) {
  switch (found.kind) {
    case ForeignKind::kVins:
      return read_vins(found.file, cameras);
    case ForeignKind::kOrb:
      return read_orb(found.file, cameras);
    case ForeignKind::kBasalt:
      return read_basalt(found.file, cameras);
    case ForeignKind::kDepthai:
      break;
  }
  return read_depthai(found.file, find_kalibr_imu(found.file.parent_path()), cameras);
}

// The places, and then those of their folders that are for calibrations.
std::vector<fs::path> with_config(const std::vector<fs::path>& places) {
  std::vector<fs::path> result = places;
  std::error_code ignored;
  for (const fs::path& place : places) {
    for (const char* name : {"config", "calib", "calibration"}) {
      if (fs::is_directory(place / name, ignored)) result.push_back(place / name);
    }
  }
  return result;
}

// A file of an IMU alone, whose noise that of the whole calibration precedes.
void remark_on_imu_file(const std::vector<fs::path>& places, const fs::path& calibration,
                        std::vector<std::string>& remarks) {
  for (const fs::path& place : with_config(places)) {
    const auto imu = find_kalibr_imu(place);
    if (!imu || *imu == calibration) continue;
    remarks.push_back(fmt::format(
        "{} is not read: the noise of the IMU is that of {}, which states it with the cameras",
        imu->string(), calibration.filename().string()));
    return;
  }
}

}  // namespace

std::optional<KalibrCalibration> read_foreign_calibration(const fs::path& file,
                                                          std::size_t cameras) {
  const auto kind = kind_of_file(file);
  if (!kind) return std::nullopt;
  return read_foreign({.file = file, .kind = *kind}, cameras);
}

std::optional<KalibrCalibration> find_foreign_calibration(const std::vector<fs::path>& places,
                                                          std::size_t cameras) {
  for (const fs::path& place : with_config(places)) {
    const std::vector<ForeignFile> found = foreign_files(place);
    if (found.empty()) continue;
    if (found.size() > 1) {
      throw InputError(fmt::format(
          "{}: both {} and {} are calibrations, expected one: take the others away", place.string(),
          found[0].file.filename().string(), found[1].file.filename().string()));
    }
    KalibrCalibration result = read_foreign(found.front(), cameras);
    if (found.front().kind != ForeignKind::kDepthai) {
      remark_on_imu_file(places, found.front().file, result.remarks);
    }
    return result;
  }
  return std::nullopt;
}

std::optional<KalibrCalibration> find_calibration(const std::vector<fs::path>& places,
                                                  std::size_t cameras) {
  for (const fs::path& place : with_config(places)) {
    if (const auto files = find_kalibr(place)) return read_kalibr(*files, cameras);
  }
  return find_foreign_calibration(places, cameras);
}

std::string insufficient_calibration(const std::vector<fs::path>& places) {
  for (const fs::path& place : with_config(places)) {
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(place, ignored)) {
      const std::string name = entry.path().filename().string();
      if (name.find("results-imucam") != std::string::npos ||
          name.find("report-imucam") != std::string::npos) {
        return fmt::format(
            " ({} is Kalibr's report for people: take the camchain-imucam.yaml that it wrote "
            "with it)",
            name);
      }
    }
  }
  return "";
}

}  // namespace chasles
