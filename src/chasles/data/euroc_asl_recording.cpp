#include <string>
#include <utility>

#include <fmt/format.h>

#include <chasles/data/csv.hpp>
#include <chasles/data/euroc_tables.hpp>
#include <chasles/data/folder_names.hpp>
#include <chasles/data/gzip.hpp>
#include <chasles/data/image_files.hpp>
#include <chasles/data/image_recording.hpp>
#include <chasles/data/inertial_tables.hpp>
#include <chasles/data/lens.hpp>
#include <chasles/data/numbers.hpp>
#include <chasles/data/readers.hpp>
#include <chasles/data/time_order.hpp>
#include <chasles/data/yaml_map.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

const Names kAslImuNames{"timestamp", "w_RS_S_x", "w_RS_S_y", "w_RS_S_z",
                         "a_RS_S_x",  "a_RS_S_y", "a_RS_S_z"};
const std::vector<Names> kImageNames{{"timestamp", "filename"}};

// The folder of the sensors: mav0 in the recording, or the recording itself.
fs::path sensors_of(const fs::path& folder) {
  return fs::is_directory(folder / "mav0") ? folder / "mav0" : folder;
}

// The folder of files that are not EuRoC's: beside mav0, also if the user named mav0 itself.
fs::path folder_of(const fs::path& folder) {
  return folder_name(folder) == "mav0" ? folder / ".." : folder;
}

std::string sequence_name(const fs::path& folder) { return folder_name(folder_of(folder)); }

Camera read_camera(const fs::path& file) {
  const YamlMap map =
      YamlMap::read(file, {.known = {},
                           .needed = {"sensor_type", "T_BS", "resolution", "camera_model",
                                      "intrinsics", "distortion_model"}});
  if (map.text("sensor_type") != "camera") {
    throw InputError(fmt::format("{}: is '{}', expected 'camera'", map.where("sensor_type"),
                                 map.text("sensor_type")));
  }
  Camera camera = read_pinhole(
      map, {.distortion_model = "distortion_model", .coefficients = "distortion_coefficients"});
  const YamlMap T = map.map("T_BS", {.known = {"cols", "rows", "data"}, .needed = {"data"}});
  const Eigen::VectorXd data = T.numbers("data", 16, "numbers, row by row");
  const SE3 imu_T_cam =
      checked_motion(T.where("data"), Eigen::Matrix4d(data.reshaped<Eigen::RowMajor>(4, 4)));
  camera.cam_T_imu = imu_T_cam.inverse();
  return camera;
}

CameraFiles read_image_list(const fs::path& camera) {
  const fs::path table = camera / "data.csv";
  CsvReader csv(table.string(), read_plain_or_gzip(table), kImageNames);
  CameraFiles files{.folder = camera / "data", .images = {}};
  while (csv.next()) {
    files.images.push_back({.time = csv.time(0), .file = std::string(csv.text(1))});
  }
  if (!files.images.empty()) return files;
  throw InputError(table.string() + ": lists no image, expected rows `time,file`");
}

std::vector<ImuSample> read_asl_samples(const fs::path& file) {
  CsvReader csv(file.string(), read_plain_or_gzip(file), {kAslImuNames});
  std::vector<ImuSample> imu;
  while (csv.next()) {
    imu.push_back({.time = csv.time(0),
                   .specific_force_imu = vector_at(csv, 4),
                   .angular_rate_imu = vector_at(csv, 1)});
  }
  return imu;
}

void read_asl_truth(const fs::path& folder, Recording& recording) {
  const fs::path states = sensors_of(folder) / "state_groundtruth_estimate0" / "data.csv";
  const fs::path poses = folder_of(folder) / "truth.tum";
  if (fs::exists(poses)) {  // not EuRoC's: placed there on purpose
    recording.truth = read_tum(poses);
  } else if (fs::exists(states)) {
    read_euroc_states(states, recording);
  } else {
    recording.remarks.push_back(
        "no truth: there is neither state_groundtruth_estimate0/data.csv nor truth.tum");
  }
}

}  // namespace

bool is_euroc_asl_folder(const fs::path& folder) {
  std::error_code ignored;
  const fs::path mav0 = folder / "mav0";
  return fs::is_directory(mav0, ignored) ||
         (fs::is_directory(folder / "cam0", ignored) && fs::is_directory(folder / "imu0", ignored));
}

Recording read_euroc_asl_recording(const fs::path& folder) {
  const fs::path sensors = sensors_of(folder);
  Recording recording;
  recording.name = sequence_name(folder);
  std::vector<CameraFiles> images;
  for (int c = 0; c == 0 || fs::is_directory(sensors / fmt::format("cam{}", c)); ++c) {
    const fs::path camera = sensors / fmt::format("cam{}", c);
    recording.cameras.push_back(read_camera(camera / "sensor.yaml"));
    images.push_back(read_image_list(camera));
  }
  recording.imu_noise = read_euroc_imu_noise(sensors / "imu0" / "sensor.yaml");
  recording.imu_range = read_euroc_imu_range(sensors / "imu0" / "sensor.yaml");
  recording.imu = read_asl_samples(sensors / "imu0" / "data.csv");
  tidy_samples(sensors / "imu0" / "data.csv", recording);
  // The cameras of a rig are triggered together: EuRoC's have identical times.
  recording.images =
      open_image_files(std::move(images), recording.cameras, kSameInstant, recording.remarks);
  read_asl_truth(folder, recording);
  recording.plan = read_plan_of(folder_of(folder));
  remark_on_coverage(recording);
  return recording;
}

}  // namespace chasles
