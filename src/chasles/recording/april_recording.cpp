#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/csv.hpp>
#include <chasles/codec/gzip.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/recording/euroc_tables.hpp>
#include <chasles/recording/gravity.hpp>
#include <chasles/recording/image_recording.hpp>
#include <chasles/recording/imu_table.hpp>
#include <chasles/recording/readers.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;
using Names = std::vector<std::string>;

const std::vector<Names> kTrackNames{{"timestamp", "cam", "corner_id", "u", "v"}};
const std::vector<Names> kLandmarkNames{{"corner_id", "x", "y", "z"}};
const std::vector<Names> kPoseNames{{"timestamp", "p_WB_x", "p_WB_y", "p_WB_z", "q_WB_w", "q_WB_x",
                                     "q_WB_y", "q_WB_z", "n_corners", "rms_px"}};

// Poses from fewer corners, or with a larger residual, jump by centimetres.
constexpr std::int64_t kFewestCorners = 64;
constexpr double kWorstFit = 1.0;    // [px]
constexpr double kOutage = 0.5;      // without a frame [s]
constexpr double kGravityOff = 0.1;  // [m/s^2]

// The table NAME.csv of a folder, or NAME.csv.gz.
fs::path table(const fs::path& folder, const std::string& name) {
  const fs::path plain = folder / (name + ".csv"), zipped = folder / (name + ".csv.gz");
  return fs::exists(zipped) && !fs::exists(plain) ? zipped : plain;
}

CsvReader open_table(const fs::path& file, const std::vector<Names>& names) {
  return {file.string(), read_plain_or_gzip(file), names};
}

std::vector<Camera> read_cameras(const fs::path& folder) {
  std::vector<Camera> cameras{read_euroc_camera_of_tracks(folder / "cam0_sensor.yaml")};
  if (fs::exists(folder / "cam1_sensor.yaml")) {
    cameras.push_back(read_euroc_camera_of_tracks(folder / "cam1_sensor.yaml"));
  }
  return cameras;
}

int camera_of(const CsvReader& csv, std::size_t cameras) {
  const std::int64_t camera = csv.integer(1);
  if (camera >= 0 && std::cmp_less(camera, cameras)) return static_cast<int>(camera);
  throw InputError(
      fmt::format("{}: there is no camera {}, expected 0 to {}, as many as there are "
                  "files camN_sensor.yaml",
                  csv.where(1), camera, cameras - 1));
}

std::vector<FeatureFrame> read_tracks(const fs::path& file, std::size_t cameras) {
  CsvReader csv = open_table(file, kTrackNames);
  std::vector<FeatureFrame> frames;
  std::set<std::pair<int, LandmarkId>> seen;
  while (csv.next()) {
    const Time time = csv.time(0);
    if (frames.empty() || time != frames.back().time) {
      if (!frames.empty()) check_rises(csv.where(0), frames.back().time, time);
      frames.push_back({.time = time});
      seen.clear();
    }
    const PixelObservation row{.landmark = csv.integer(2),
                               .camera = camera_of(csv, cameras),
                               .pixel = {csv.finite(3), csv.finite(4)}};
    if (!seen.emplace(row.camera, row.landmark).second) {
      throw InputError(
          fmt::format("{}: corner {} is there twice in camera {} at {} ns, expected "
                      "at most once",
                      csv.where(2), row.landmark, row.camera, time.count()));
    }
    frames.back().pixels.push_back(row);
  }
  return frames;
}

Trajectory read_poses(const fs::path& file, std::vector<std::string>& remarks) {
  CsvReader csv = open_table(file, kPoseNames);
  Trajectory poses;
  Time before = Time::min();
  int left_out = 0, rows = 0;
  for (; csv.next(); ++rows) {
    const Time time = csv.time(0);
    if (rows > 0) check_rises(csv.where(0), before, time);
    before = time;
    const Eigen::Vector4d xyzw(csv.finite(5), csv.finite(6), csv.finite(7), csv.finite(4));
    const StampedPose row{.time = time,
                          .pose = {checked_quaternion(csv.where(), xyzw),
                                   {csv.finite(1), csv.finite(2), csv.finite(3)}}};
    if (csv.integer(8) >= kFewestCorners && csv.finite(9) <= kWorstFit) {
      poses.push_back(row);
    } else {
      ++left_out;
    }
  }
  if (left_out > 0) {
    remarks.push_back(fmt::format(
        "{} of {} poses of the truth use fewer than {} corners or fit them worse than {} px: "
        "left out of the truth",
        left_out, rows, kFewestCorners, kWorstFit));
  }
  return poses;
}

std::vector<TrueLandmark> read_corners(const fs::path& file) {
  CsvReader csv = open_table(file, kLandmarkNames);
  std::vector<TrueLandmark> corners;
  while (csv.next()) {
    corners.push_back(
        {.id = csv.integer(0), .p_world = {csv.finite(1), csv.finite(2), csv.finite(3)}});
  }
  return corners;
}

// The board has an arbitrary attitude. Rotates everything in its frame so that z points up, by the
// gravity that truth and IMU together determine.
void make_level(const fs::path& file, Recording& recording) {
  const auto fit = fit_gravity(recording.truth, recording.imu);
  if (!fit) {
    throw InputError(
        file.string() +
        ": too few poses during the IMU's samples to determine the vertical, expected at "
        "least 5 s of them");
  }
  const double size = fit->gravity_world.norm();
  if (!(std::abs(size - kStandardGravity) <= kGravityOff)) {
    throw InputError(fmt::format(
        "{}: with the IMU's samples gravity is {:.3f} m/s^2, expected {:.3f} within {}: are the "
        "poses of another recording, or of another frame than the IMU's?",
        file.string(), size, kStandardGravity, kGravityOff));
  }
  const Eigen::Vector3d up = -fit->gravity_world / size;
  const Eigen::Matrix3d level_R_board = so3::between(up, Eigen::Vector3d::UnitZ());
  const SE3 level_T_board{level_R_board, Eigen::Vector3d::Zero()};
  for (StampedPose& row : recording.truth) row.pose = level_T_board * row.pose;
  for (TrueLandmark& row : recording.true_landmarks) row.p_world = level_T_board * row.p_world;
  recording.remarks.push_back(fmt::format(
      "up is ({:.3f}, {:.3f}, {:.3f}) in the board's frame (gravity {:.3f} m/s^2 from {} windows): "
      "truth and landmarks are turned so that z points up",
      up.x(), up.y(), up.z(), size, fit->windows));
}

void remark_on_times(Recording& r) {
  for (std::size_t k = 1; k < r.frames.size(); ++k) {
    const double gap = to_seconds(r.frames[k].time - r.frames[k - 1].time);
    if (gap < kOutage) continue;
    r.remarks.push_back(fmt::format("no frame for {:.2f} s, from {:.2f} s on: no image data", gap,
                                    to_seconds(r.frames[k - 1].time - r.frames.front().time)));
  }
  const auto outside = std::count_if(r.frames.begin(), r.frames.end(), [&](const auto& frame) {
    return frame.time < r.imu.front().time || frame.time > r.imu.back().time;
  });
  if (outside == 0) return;
  r.remarks.push_back(
      fmt::format("{} of {} frames are before the first IMU sample or after the last: kept",
                  outside, r.frames.size()));
}

std::string name_of(const fs::path& folder) {
  const fs::path path = fs::absolute(folder).lexically_normal();
  return (path.has_filename() ? path : path.parent_path()).filename().string();
}

}  // namespace

Recording read_april_recording(const fs::path& folder) {
  Recording recording;
  recording.name = name_of(folder);
  recording.cameras = read_cameras(folder);
  recording.imu_noise = read_euroc_imu_noise(folder / "imu0_sensor.yaml");
  recording.imu_range = read_euroc_imu_range(folder / "imu0_sensor.yaml");
  recording.imu = read_imu_table(table(folder, "imu0"), recording.remarks);
  tidy_samples(table(folder, "imu0"), recording);
  remark_on_open_end(table(folder, "imu0"), recording.remarks);
  recording.frames = read_tracks(table(folder, "tracks"), recording.cameras.size());
  remark_on_times(recording);
  const fs::path poses = table(folder, "gt_pnp"), corners = table(folder, "landmarks");
  if (!fs::exists(poses)) return recording;
  recording.truth = read_poses(poses, recording.remarks);
  if (fs::exists(corners)) recording.true_landmarks = read_corners(corners);
  make_level(poses, recording);
  return recording;
}

}  // namespace chasles
