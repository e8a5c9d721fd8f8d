#include <array>
#include <fstream>

#include <fmt/format.h>

#include <chasles/data/euroc_tables.hpp>
#include <chasles/data/gzip.hpp>
#include <chasles/data/readers.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

constexpr const char* kKnownKinds =
    "an ECE276A .npz archive, a STARS .mat file, an EuRoC IMU table, a folder of AprilGrid tracks "
    "(tracks.csv), or a recording folder with calibration.yaml (docs/formats.md)";

std::string first_bytes(const std::filesystem::path& file) {
  std::array<char, 128> bytes{};
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(fmt::format("{}: cannot be opened", file.string()));
  stream.read(bytes.data(), bytes.size());
  return {bytes.data(), static_cast<std::size_t>(stream.gcount())};
}

Recording read_folder(const std::filesystem::path& folder) {
  std::error_code ignored;
  const auto holds = [&](const char* file) {
    return std::filesystem::exists(folder / file, ignored);
  };
  if (holds("calibration.yaml")) return read_folder_recording(folder);
  if (holds("tracks.csv") || holds("tracks.csv.gz")) return read_april_recording(folder);
  throw InputError(
      fmt::format("{}: the folder holds no calibration.yaml and no tracks.csv, "
                  "expected {}",
                  folder.string(), kKnownKinds));
}

}  // namespace

Recording read_recording(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    throw InputError(
        fmt::format("{}: no such file or folder, expected {}", path.string(), kKnownKinds));
  }
  if (std::filesystem::is_directory(path, ignored)) return read_folder(path);
  const std::string bytes = first_bytes(path);
  if (bytes.starts_with("PK\x03\x04") || bytes.starts_with("PK\x05\x06")) {
    return read_npz_recording(path);
  }
  if (bytes.starts_with("MATLAB 5.0") || bytes.starts_with("MATLAB 7.3") ||
      bytes.starts_with("\x89HDF\r\n")) {
    return read_mat_recording(path);
  }
  if (is_gzip(bytes) || begins_euroc_imu(bytes)) return read_euroc_imu_recording(path);
  throw InputError(fmt::format("{}: {}, expected {}", path.string(),
                               bytes.empty() ? "is empty" : "its first bytes are of no known kind",
                               kKnownKinds));
}

}  // namespace chasles
