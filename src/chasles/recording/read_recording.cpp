#include <algorithm>
#include <array>
#include <fstream>
#include <optional>

#include <fmt/format.h>

#include <chasles/bags/bag_file.hpp>
#include <chasles/bags/bag_paths.hpp>
#include <chasles/bags/packed_file.hpp>
#include <chasles/base/error.hpp>
#include <chasles/codec/foreign_files.hpp>
#include <chasles/codec/gzip.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/codec/utf8.hpp>
#include <chasles/recording/euroc_tables.hpp>
#include <chasles/recording/foreign_kinds.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/time_spans.hpp>
#include <chasles/recording/video_files.hpp>

namespace chasles {
namespace {

constexpr const char* kKnownKinds =
    "an ECE276A .npz archive, a STARS .mat file, an EuRoC folder (mav0), IMU table or table of "
    "tracks, a folder of AprilGrid tracks (tracks.csv), a KITTI raw recording (image_00, oxts) or "
    "odometry sequence (image_0, times.txt) with an IMU, a bag of ROS 1 (.bag) or ROS 2 (.db3, "
    ".mcap), a folder of images (images/cam0, imu.csv), a video (.mp4, .mov), or a recording "
    "folder with "
    "calibration.yaml (docs/formats.md)";

std::string first_bytes(const std::filesystem::path& file) {
  check_regular_file(file);
  std::array<char, 512> bytes{};  // a tar archive has its mark at 257
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw InputError(fmt::format("{}: cannot be opened", file.string()));
  stream.read(bytes.data(), bytes.size());
  return {bytes.data(), static_cast<std::size_t>(stream.gcount())};
}

[[noreturn]] void unknown(const std::filesystem::path& path, const std::string& what) {
  throw InputError(fmt::format("{}: {}, expected {}", path.string(), what, kKnownKinds));
}

// Rejects what is known to be no recording, with what to do.
void reject_foreign(const std::filesystem::path& path, const std::optional<std::string>& verdict) {
  if (verdict) throw InputError(fmt::format("{}: {}", path.string(), *verdict));
}

Recording read_folder(const std::filesystem::path& folder, std::size_t cameras) {
  std::error_code ignored;
  const auto holds = [&](const char* file) {
    return std::filesystem::exists(folder / file, ignored);
  };
  if (is_euroc_asl_folder(folder)) return read_euroc_asl_recording(folder, cameras);
  if (is_kitti_raw_folder(folder)) return read_kitti_raw_recording(folder, cameras);
  if (is_kitti_odometry_folder(folder)) return read_kitti_odometry_recording(folder, cameras);
  if (holds("states.csv") && holds("summary.json")) {
    reject_foreign(folder, foreign_folder(folder));  // a run may hold images/ too
  }
  if (is_image_folder(folder)) return read_image_folder_recording(folder, cameras);
  if (is_video_folder(folder) && !is_bag_folder(folder)) return read_video_recording(folder);
  if (holds("calibration.yaml")) return read_folder_recording(folder);
  if (holds("tracks.csv") || holds("tracks.csv.gz")) return read_april_recording(folder);
  if (is_bag_folder(folder)) return read_bag_recording(folder, cameras);
  reject_foreign(folder, foreign_folder(folder));
  unknown(folder, "the folder holds no calibration.yaml nor any other first file of a recording");
}

// A table whose first line identifies it, plain or compressed.
Recording read_table(const std::filesystem::path& path) {
  std::string bytes = read_plain_or_gzip(path);
  remove_byte_order_mark(bytes);
  return begins_klt_tracks(bytes) ? read_klt_tracks_recording(path)
                                  : read_euroc_imu_recording(path);
}

// A bag or a table that is compressed as a whole.
Recording read_packed(const std::filesystem::path& path, const std::string& first,
                      const ReaderSettings& settings) {
  const std::string_view packed = packed_as(first);
  const std::string bytes = first_unpacked(path, first.size());
  if (begins_bag(bytes)) return read_bag_recording(path, settings.cameras);
  reject_foreign(path, foreign_file(path, bytes.empty() ? first : bytes));
  if (packed == "gz") return read_table(path);
  unknown(path, fmt::format("is compressed as a whole ({}), and what it holds is of no known kind",
                            packed));
}

Recording read_file_recording(const std::filesystem::path& path, const ReaderSettings& settings) {
  std::string bytes = first_bytes(path);
  remove_byte_order_mark(bytes);
  if (is_video_file(path, bytes)) return read_video_recording(path);
  if (!packed_as(bytes).empty()) return read_packed(path, bytes, settings);
  reject_foreign(path, foreign_file(path, bytes));
  if (bytes.starts_with("PK\x03\x04") || bytes.starts_with("PK\x05\x06")) {
    return read_npz_recording(path, settings);
  }
  if (bytes.starts_with("MATLAB 5.0") || bytes.starts_with("MATLAB 7.3") ||
      bytes.starts_with("\x89HDF\r\n")) {
    return read_mat_recording(path);
  }
  if (begins_bag(bytes)) return read_bag_recording(path, settings.cameras);
  if (begins_euroc_imu(bytes) || begins_klt_tracks(bytes)) return read_table(path);
  unknown(path, "its first bytes are of no known kind");
}

Recording read_whatever(const std::filesystem::path& path, const ReaderSettings& settings) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) unknown(path, "no such file or folder");
  if (std::filesystem::is_directory(path, ignored)) return read_folder(path, settings.cameras);
  return read_file_recording(path, settings);
}

// A calibration of another image size is found before the run, not at each image of it.
void check_image_sizes(const Recording& recording) {
  constexpr std::size_t kTries = 5;  // one image may be damaged, or one camera's missing
  const std::size_t frames = recording.images ? recording.images->size() : 0;
  for (std::size_t i = 0; i < std::min(frames, kTries); ++i) {
    try {
      const ImageFrame frame = recording.images->read(i);
      if (std::ranges::none_of(frame.images, &GrayImage::empty)) return;
    } catch (const ImageSizeError& error) {
      throw InputError(
          fmt::format("{}: take a calibration of this size, or scale the images", error.what()));
    } catch (const InputError&) {
    }
  }
}

}  // namespace

Recording read_recording(const std::filesystem::path& path, const ReaderSettings& settings) {
  Recording recording = read_whatever(path, settings);
  check_image_sizes(recording);
  check_time_spans(path.string(), recording);
  recording.name = valid_utf8(recording.name);
  for (std::string& remark : recording.remarks) remark = valid_utf8(remark);
  return recording;
}

}  // namespace chasles
