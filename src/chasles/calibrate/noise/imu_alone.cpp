#include <fstream>
#include <string>
#include <vector>

#include <fmt/format.h>

#include <chasles/bags/bag_contents.hpp>
#include <chasles/bags/bag_file.hpp>
#include <chasles/bags/bag_imu.hpp>
#include <chasles/bags/bag_paths.hpp>
#include <chasles/base/error.hpp>
#include <chasles/calibrate/noise/imu_alone.hpp>
#include <chasles/codec/folder_names.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/image_recording.hpp>
#include <chasles/recording/imu_table.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/sensor_tables.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

void read_table_alone(const fs::path& table, Recording& recording) {
  recording.imu = read_imu_table(table, recording.remarks);
  tidy_samples(table, recording);
}

bool read_bag_alone(const fs::path& path, Recording& recording) {
  const BagPaths paths = find_bag_files(path);
  const BagContents contents = scan_bags(paths.files);
  std::vector<const TopicContents*> topics;
  std::vector<std::string> names;
  for (const TopicContents& topic : contents.topics) {
    if (topic.imu.empty() || measured_parts(topic) != ImuParts::kBoth) continue;
    topics.push_back(&topic);
    names.push_back(topic.topic.name);
  }
  if (topics.size() > 1) {
    throw InputError(
        fmt::format("{}: found the IMU topics {}, expected one: write a bag with one of them",
                    path.string(), quoted_list(names)));
  }
  if (topics.empty()) return false;
  recording.name = paths.name;
  recording.imu = topics.front()->imu;
  tidy_samples(fmt::format("{}: topic {}", path.string(), names.front()), recording);
  return true;
}

bool is_bag(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) return is_bag_folder(path);
  if (!fs::is_regular_file(path, ignored)) return false;
  std::string first(16, '\0');
  std::ifstream(path, std::ios::binary).read(first.data(), std::ssize(first));
  return begins_bag(first);
}

bool read_samples_alone(const fs::path& path, Recording& recording) {
  std::error_code ignored;
  if (is_bag(path)) return read_bag_alone(path, recording);
  if (fs::is_regular_file(path, ignored)) {
    recording.name = path.stem().string();
    if (!is_imu_table(path)) return false;
    read_table_alone(path, recording);
    return true;
  }
  if (!fs::is_directory(path, ignored)) return false;
  recording.name = folder_name(path);
  if (const auto table = find_imu_table(path, recording.remarks)) {
    read_table_alone(*table, recording);
    return true;
  }
  const SensorTables tables = find_sensor_tables(path);
  if (!tables.accelerometer || !tables.gyroscope) return false;
  read_sensor_tables(tables, path, recording);
  return true;
}

}  // namespace

Recording read_for_imu(const fs::path& path) {
  try {
    return read_recording(path);
  } catch (const InputError& error) {
    Recording recording;
    if (!read_samples_alone(path, recording)) throw;
    recording.remarks.push_back(
        fmt::format("only the IMU's samples were read; as a recording: {}", error.what()));
    return recording;
  }
}

}  // namespace chasles
