#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/foreign_calibration.hpp>
#include <chasles/calibration/kalibr.hpp>
#include <chasles/codec/csv.hpp>
#include <chasles/codec/folder_names.hpp>
#include <chasles/recording/apply_calibration.hpp>
#include <chasles/recording/gopro_json.hpp>
#include <chasles/recording/image_recording.hpp>
#include <chasles/recording/image_times.hpp>
#include <chasles/recording/imu_table.hpp>
#include <chasles/recording/masks.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/sensor_tables.hpp>
#include <chasles/recording/split_imu.hpp>
#include <chasles/recording/time_order.hpp>
#include <chasles/recording/truth_table.hpp>
#include <chasles/recording/video_files.hpp>
#include <chasles/recording/video_images.hpp>
#include <chasles/video/telemetry.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// Beside the video, or above the folder of one demonstration among many.
KalibrCalibration calibrate_video(const VideoPlace& place, Recording& recording) {
  std::vector<fs::path> folders{place.folder};
  const fs::path above = fs::absolute(place.folder).lexically_normal().parent_path();
  if (place.by_folder)
    folders.push_back(place.folder.filename().empty() ? above.parent_path() : above);
  if (const auto own = place.first_of({".yaml", ".yml"}, {})) {
    return take_own_calibration(*own, 1, recording);
  }
  for (const fs::path& folder : folders) {
    std::optional<KalibrCalibration> found;
    if (fs::exists(folder / "calibration.yaml")) {
      found = take_own_calibration(folder / "calibration.yaml", 1, recording);
    } else if ((found = find_calibration({folder}, 1))) {
      take_kalibr(*found, recording);
    }
    if (!found) continue;
    if (folder != place.folder) {
      recording.remarks.push_back(fmt::format(
          "{} has no calibration: that of the folder above it is taken", place.folder.string()));
    }
    return *found;
  }
  throw InputError(fmt::format(
      "{}: there is no calibration of the camera and the IMU beside it: expected {}, "
      "calibration.yaml, Kalibr's camchain-imucam.yaml and imu.yaml, or the files of OpenVINS, "
      "VINS-Fusion, ORB-SLAM3 or Basalt (docs/your-recording.md){}",
      place.video.string(), place.beside(".yaml").filename().string(),
      insufficient_calibration(folders)));
}

// A table of samples that belongs to the video.
bool read_table_of_video(const VideoPlace& place, const VideoIndex& index, Recording& recording) {
  std::optional<fs::path> table = place.first_of({"_imu.csv", ".csv"}, {"imu.csv"});
  if (!table && place.is_alone) table = find_imu_table(place.folder, recording.remarks);
  if (table) {
    recording.imu = read_imu_table(*table, recording.remarks);
    tidy_samples(*table, recording);
    remark_on_open_end(*table, recording.remarks);
    return true;
  }
  const auto json = place.first_of({"_imu.json", ".json"}, {"imu_data.json"});
  // Beside a video any .json may be anything, but for this name.
  if (json && (json->filename() == "imu_data.json" || is_gopro_json(*json))) {
    GoproJson imu = read_gopro_json(*json, index.pictures, recording.remarks);
    join_streams(json->string(), std::move(imu.forces), std::move(imu.rates),
                 Eigen::Matrix3d::Identity(), recording);
    return true;
  }
  const SensorTables apart = place.is_alone ? find_sensor_tables(place.folder) : SensorTables{};
  if (!apart.accelerometer && !apart.gyroscope) return false;
  read_sensor_tables(apart, place.folder, recording);
  return true;
}

// A table beside the video counts before the telemetry in it.
void read_samples_of_video(const VideoPlace& place, const VideoIndex& index, Recording& recording) {
  if (read_table_of_video(place, index, recording)) {
    if (!index.telemetry.empty()) {
      recording.remarks.push_back(
          "the video has telemetry of its own, which is not read: the table beside it is");
    }
    return;
  }
  if (index.telemetry.empty()) {
    throw InputError(fmt::format(
        "{}: has no samples of an IMU: expected telemetry of a GoPro in it, or a table beside it: "
        "{}, or imu.csv or imu_data.json where it is the only video (docs/videos.md)",
        place.video.string(), place.beside("_imu.csv").filename().string()));
  }
  Telemetry telemetry = read_telemetry(index, recording.remarks);
  join_streams(index.file, {.name = "ACCL", .samples = std::move(telemetry.forces)},
               {.name = "GYRO", .samples = std::move(telemetry.rates)}, Eigen::Matrix3d::Identity(),
               recording);
}

// As the file states them; or by a list that an app writes by the clock of the IMU.
std::vector<Time> times_of_pictures(const VideoPlace& place, const VideoIndex& index, Time offset,
                                    std::vector<std::string>& remarks) {
  std::vector<Time> times;
  const auto list =
      place.first_of({"_timestamps.csv", "_timestamps.txt", "_times.csv", "_times.txt"},
                     {"frame_timestamps.txt", "frame_timestamps.csv", "timestamps.txt",
                      "timestamps.csv", "times.txt", "times.csv"});
  if (list) {
    times = read_time_list(*list, remarks);
    if (times.size() != index.pictures.size()) {
      throw InputError(fmt::format("{}: has {} times, expected {}: one for each picture of {}",
                                   list->string(), times.size(), index.pictures.size(),
                                   index.file));
    }
    for (std::size_t i = 1; i < times.size(); ++i) {
      if (times[i] > times[i - 1]) continue;
      throw InputError(
          fmt::format("{}: the time of picture {} is not later than the one before, "
                      "expected them in the order of the video",
                      list->string(), i));
    }
    remarks.push_back(
        fmt::format("the times of the pictures are those of {}", list->filename().string()));
  } else {
    for (const VideoPicture& picture : index.pictures) times.push_back(picture.time);
  }
  for (Time& time : times) time = by_imu_clock(time, offset, index.file);
  return times;
}

void take_mask(const VideoPlace& place, Recording& recording) {
  const auto mask = place.first_of({"_mask.png"}, {"mask.png", "slam_mask.png"});
  if (!mask) return;
  const std::string name = mask->filename().string();
  const bool white = name == "slam_mask.png";
  recording.masks = {read_mask(*mask, white ? MaskKind::kWhiteHides : MaskKind::kBlackHides,
                               recording.cameras.front())};
  recording.remarks.push_back(fmt::format(
      "{} hides {:.1f} % of the pictures, where it is {} (--set frontend.mask=FILE "
      "takes another)",
      name, 100 * covered_share(recording.masks.front()), white ? "not black" : "black"));
}

}  // namespace

bool is_video_folder(const fs::path& folder) {
  std::error_code ignored;
  return !fs::exists(folder / "frames.csv", ignored) && !videos_in(folder).empty();
}

Recording read_video_recording(const fs::path& path) {
  const VideoPlace place = find_video(path);
  Recording recording;
  recording.name = place.by_folder ? folder_name(path) : place.video.stem().string();
  const std::string name = recording.name;
  const KalibrCalibration rig = calibrate_video(place, recording);
  recording.name = name;  // calibration.yaml may be that of many recordings
  VideoIndex index = read_video_index(place.video, recording.remarks);
  read_samples_of_video(place, index, recording);
  index.telemetry.clear();  // the pictures keep the index
  take_noise_of_samples(rig, recording);
  if (rig.imu_intrinsics) correct_samples(*rig.imu_intrinsics, recording);
  std::vector<Time> times =
      times_of_pictures(place, index, rig.time_offsets.front(), recording.remarks);
  recording.images =
      open_video_images(std::move(index), std::move(times), recording.cameras.front());
  take_mask(place, recording);
  if (const auto truth = place.first_of({".tum"}, {"truth.tum"})) {
    read_truth_of_recording(*truth, recording);
  }
  if (const auto next = next_chapter(place.video)) {
    recording.remarks.push_back(
        fmt::format("the recording goes on in {}, which is not read", next->filename().string()));
  }
  remark_on_coverage(recording);
  return recording;
}

}  // namespace chasles
