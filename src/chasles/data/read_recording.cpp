#include <array>
#include <fstream>

#include <fmt/format.h>

#include <chasles/data/euroc_tables.hpp>
#include <chasles/data/gzip.hpp>
#include <chasles/data/readers.hpp>
#include <chasles/data/utf8.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

constexpr const char* kKnownKinds =
    "an ECE276A .npz archive, a STARS .mat file, an EuRoC folder (mav0), IMU table or table of "
    "tracks, a folder of AprilGrid tracks (tracks.csv), a KITTI raw recording (image_00, oxts), a "
    "ROS 1 .bag, a folder of images (images/cam0, imu.csv), or a recording folder with "
    "calibration.yaml (docs/formats.md)";

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
  if (is_euroc_asl_folder(folder)) return read_euroc_asl_recording(folder);
  if (is_kitti_raw_folder(folder)) return read_kitti_raw_recording(folder);
  if (holds("images") && !holds("frames.csv")) return read_image_folder_recording(folder);
  if (holds("calibration.yaml")) return read_folder_recording(folder);
  if (holds("tracks.csv") || holds("tracks.csv.gz")) return read_april_recording(folder);
  throw InputError(fmt::format(
      "{}: the folder holds no calibration.yaml nor any other first file of a recording, "
      "expected {}",
      folder.string(), kKnownKinds));
}

// A table whose first line identifies it, plain or compressed.
Recording read_table(const std::filesystem::path& path) {
  const bool tracks = begins_klt_tracks(read_plain_or_gzip(path));
  return tracks ? read_klt_tracks_recording(path) : read_euroc_imu_recording(path);
}

Recording read_whatever(const std::filesystem::path& path, const ReaderSettings& settings) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    throw InputError(
        fmt::format("{}: no such file or folder, expected {}", path.string(), kKnownKinds));
  }
  if (std::filesystem::is_directory(path, ignored)) return read_folder(path);
  const std::string bytes = first_bytes(path);
  if (bytes.starts_with("PK\x03\x04") || bytes.starts_with("PK\x05\x06")) {
    return read_npz_recording(path, settings);
  }
  if (bytes.starts_with("MATLAB 5.0") || bytes.starts_with("MATLAB 7.3") ||
      bytes.starts_with("\x89HDF\r\n")) {
    return read_mat_recording(path);
  }
  if (bytes.starts_with("#ROSBAG V")) return read_bag_recording(path);
  if (is_gzip(bytes) || begins_euroc_imu(bytes) || begins_klt_tracks(bytes)) {
    return read_table(path);
  }
  throw InputError(fmt::format("{}: {}, expected {}", path.string(),
                               bytes.empty() ? "is empty" : "its first bytes are of no known kind",
                               kKnownKinds));
}

}  // namespace

Recording read_recording(const std::filesystem::path& path, const ReaderSettings& settings) {
  Recording recording = read_whatever(path, settings);
  recording.name = valid_utf8(recording.name);
  for (std::string& remark : recording.remarks) remark = valid_utf8(remark);
  return recording;
}

}  // namespace chasles
