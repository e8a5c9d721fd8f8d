#include <algorithm>
#include <memory>
#include <optional>

#include <fmt/format.h>

#include <chasles/bags/bag_contents.hpp>
#include <chasles/bags/bag_imu.hpp>
#include <chasles/bags/bag_paths.hpp>
#include <chasles/bags/bag_topics.hpp>
#include <chasles/base/error.hpp>
#include <chasles/calibration/foreign_calibration.hpp>
#include <chasles/calibration/kalibr.hpp>
#include <chasles/recording/apply_calibration.hpp>
#include <chasles/recording/bag_calibration.hpp>
#include <chasles/recording/bag_images.hpp>
#include <chasles/recording/image_recording.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/split_imu.hpp>
#include <chasles/recording/time_spans.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

// Of the whole chain, because the bag may not have its first cameras; of the first ones if a later
// one cannot be read.
KalibrCalibration read_chain(const KalibrFiles& files, std::size_t cameras) {
  try {
    return read_kalibr(files);
  } catch (const InputError&) {
    return read_kalibr(files, cameras);
  }
}

bool has_imu_file(const BagPaths& paths) {
  return std::ranges::any_of(
      paths.folders, [](const fs::path& folder) { return find_kalibr_imu(folder).has_value(); });
}

// Kalibr's two files in the nearest folder that has them, else those of another program. Where
// there is an imu.yaml alone, the bag may calibrate the cameras itself.
std::optional<KalibrCalibration> kalibr_of(const BagPaths& paths, std::size_t cameras) {
  for (const fs::path& folder : paths.folders) {
    if (const auto files = find_kalibr(folder)) return read_chain(*files, cameras);
  }
  if (has_imu_file(paths)) return std::nullopt;
  return find_calibration(paths.folders);
}

// The same for a bag that has no CameraInfo.
std::optional<KalibrCalibration> foreign_of(const std::string& bag, const BagPaths& paths,
                                            const BagContents& contents) {
  const bool info = std::ranges::any_of(contents.topics, [](const TopicContents& topic) {
    return is_of(topic, "sensor_msgs/CameraInfo");
  });
  if (info) return std::nullopt;
  auto found = find_calibration(paths.folders);
  const std::string hint = insufficient_calibration(paths.folders);
  if (found || hint.empty()) return found;
  throw InputError(fmt::format(
      "{}: has no sensor_msgs/CameraInfo, and there is no camchain-imucam.yaml beside it, expected "
      "the calibration of the cameras{}",
      bag, hint));
}

// A folder that rosbag2 did not describe may have its calibration beside it too; files in it alone
// count where there are any.
void search_above(BagPaths& paths) {
  if (!paths.above) return;
  const fs::path& folder = paths.folders.front();
  if (find_kalibr(folder) || find_kalibr_imu(folder) || find_calibration({folder}) ||
      fs::exists(folder / "topics.yaml")) {
    paths.folders.pop_back();
    return;
  }
  paths.remarks.push_back(
      fmt::format("{} has no calibration: that of the folder above it is taken", folder.string()));
}

// Throws if the first messages of a bag are all of a serialisation that is not read: without a
// calibration that is the better reason.
void reject_foreign_messages(const OpenBag& bag) {
  constexpr std::size_t kMostSearched = 1000;
  struct Enough {};
  std::vector<TopicContents> topics;
  std::size_t searched = 0;
  std::vector<std::string> ignored;
  try {
    bag.file->scan(
        [&](const BagMessage& message) {
          const bool known = message.topic->wire != Wire::kOther;
          if (topics.empty() || known) topics.emplace_back().topic = *message.topic;
          if (known || ++searched == kMostSearched) throw Enough{};
        },
        ignored);
  } catch (const Enough&) {
  }
  check_serialisation(bag.path.string(), topics);
}

KalibrCalibration imu_of(const std::string& bag, const BagPaths& paths,
                         const std::vector<OpenBag>& bags) {
  for (const fs::path& folder : paths.folders) {
    if (const auto file = find_kalibr_imu(folder)) return read_kalibr_imu(*file);
  }
  for (const OpenBag& one : bags) reject_foreign_messages(one);
  throw InputError(fmt::format(
      "{}: there is neither camchain-imucam.yaml nor imu.yaml beside it, expected Kalibr's two "
      "files, or, if the bag has CameraInfo and /tf_static, an imu.yaml with the noise of the IMU: "
      "accelerometer_noise_density, accelerometer_random_walk, gyroscope_noise_density and "
      "gyroscope_random_walk (docs/your-recording.md). The files of OpenVINS, VINS-Fusion, "
      "ORB-SLAM3 "
      "and Basalt serve as well{}",
      bag, insufficient_calibration(paths.folders)));
}

// Throws for a topic without a message that can be used.
void check_topic(const std::string& bag, const TopicContents& topic, std::size_t used,
                 std::vector<std::string>& remarks) {
  if (!topic.damage.empty()) throw InputError(topic.damage);
  if (topic.unset == 0) return;
  if (used == 0) {
    throw InputError(fmt::format(
        "{}: topic {}: header.stamp of all {} messages is 0, expected the times of the "
        "measurements: the driver did not set the stamps, set them and write the bag anew",
        bag, topic.topic.name, topic.unset));
  }
  remarks.push_back(fmt::format("{} of {} messages of {} have a header.stamp of 0: left out",
                                topic.unset, topic.messages, topic.topic.name));
}

SensorStream stream_of(const TopicContents& topic, Eigen::Vector3d ImuSample::*part) {
  SensorStream stream{.name = topic.topic.name, .samples = {}};
  for (const ImuSample& s : topic.imu) stream.samples.push_back({.time = s.time, .value = s.*part});
  return stream;
}

// The IMU of two topics. Cameras that the bag calibrates are calibrated against the gyroscope's
// frame, and the origin of the IMU is the accelerometer's.
void take_split_samples(const std::string& bag, const BagContents& contents,
                        const ChosenTopics& chosen, bool by_bag, Recording& recording) {
  const TopicContents &forces = *chosen.accelerometer, &rates = *chosen.imu;
  for (const TopicContents* topic : {&forces, &rates}) {
    check_topic(bag, *topic, topic->imu.size(), recording.remarks);
  }
  const SplitExtrinsics extrinsics = split_extrinsics(forces, rates, contents);
  join_streams(bag, stream_of(forces, &ImuSample::specific_force_imu),
               stream_of(rates, &ImuSample::angular_rate_imu), extrinsics.gyro_T_accel.R,
               recording);
  for (const std::string& remark : extrinsics.remarks) {  // those of the cameras are there
    const bool said = std::ranges::find(recording.remarks, remark) != recording.remarks.end();
    if (!said) recording.remarks.push_back(remark);
  }
  for (Camera& camera : recording.cameras) {
    if (by_bag)
      camera.cam_T_imu =
          camera.cam_T_imu * SE3{Eigen::Matrix3d::Identity(), extrinsics.gyro_T_accel.p};
  }
}

void take_samples(const std::string& bag, const TopicContents& topic, Recording& recording) {
  check_topic(bag, topic, topic.imu.size(), recording.remarks);
  recording.imu = topic.imu;
  tidy_samples(fmt::format("{}: topic {}", bag, topic.topic.name), recording);
}

// `offsets`: of each camera, added to its stamps; empty: none.
void take_cameras(const std::string& bag, const BagContents& contents, const ChosenTopics& chosen,
                  const std::vector<Time>& offsets, Recording& recording) {
  for (const TopicContents* topic : chosen.cameras) {
    check_topic(bag, *topic, topic->images.size(), recording.remarks);
    std::vector<Time> times;
    for (const BagImage& image : topic->images) times.push_back(image.time);
    check_distinct(fmt::format("{}: topic {}", bag, topic->topic.name), "images", std::move(times));
  }
  recording.images = open_bag_images(contents.files, chosen.cameras, recording.cameras, offsets,
                                     bag, recording.remarks);
}

}  // namespace

Recording read_bag_recording(const fs::path& path, std::size_t cameras) {
  const std::string bag = path.string();
  BagPaths paths = find_bag_files(path);
  const std::vector<OpenBag> bags = open_bags(paths.files);  // what is no bag comes first
  search_above(paths);
  auto kalibr = kalibr_of(paths, cameras);
  KalibrCalibration calibration = kalibr ? *kalibr : imu_of(bag, paths, bags);
  const BagContents contents = scan_open_bags(bags);
  if (!kalibr && (kalibr = foreign_of(bag, paths, contents))) calibration = *kalibr;
  ChosenTopics chosen =
      choose_topics(bag, contents.topics, kalibr ? &*kalibr : nullptr, paths.folders, cameras);
  if (chosen.cameras.size() > cameras) {
    chosen.cameras.resize(cameras);
    chosen.chain.resize(cameras);
  }
  Recording recording;
  recording.name = paths.name;
  recording.imu_noise = calibration.imu_noise;
  recording.imu_range = calibration.imu_range;
  for (const auto& remarks :
       {paths.remarks, contents.remarks, calibration.remarks, chosen.remarks}) {
    recording.remarks.insert(recording.remarks.end(), remarks.begin(), remarks.end());
  }
  if (paths.files.size() > 1) {
    recording.remarks.push_back(
        fmt::format("{} bags are read as one recording", paths.files.size()));
  }
  std::vector<Time> offsets;
  if (kalibr) {
    for (const std::size_t c : chosen.chain) {
      recording.cameras.push_back(calibration.cameras[c]);
      offsets.push_back(calibration.time_offsets[c]);
    }
  } else {
    calibrate_by_bag(bag, contents, chosen, recording);
  }
  if (chosen.accelerometer != nullptr) {
    take_split_samples(bag, contents, chosen, !kalibr, recording);
  } else {
    take_samples(bag, *chosen.imu, recording);
  }
  take_noise_of_samples(calibration, recording);
  if (calibration.imu_intrinsics) correct_samples(*calibration.imu_intrinsics, recording);
  take_cameras(bag, contents, chosen, offsets, recording);
  remark_on_coverage(recording);
  return recording;
}

}  // namespace chasles
