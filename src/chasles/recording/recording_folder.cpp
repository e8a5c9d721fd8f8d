#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/calibration.hpp>
#include <chasles/codec/csv.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/codec/text_file.hpp>
#include <chasles/recording/frame_cursor.hpp>
#include <chasles/recording/image_recording.hpp>
#include <chasles/recording/inertial_tables.hpp>
#include <chasles/recording/readers.hpp>
#include <chasles/recording/truth_table.hpp>

namespace chasles {
namespace {

const std::vector<std::string> kVelocityColumns{"time_ns", "vx", "vy", "vz", "wx", "wy", "wz"};
// With single cameras also the number of their observations.
const std::vector<std::string> kFrameColumns{"time_ns", "observations"};
const std::vector<std::string> kFramePixelColumns{"time_ns", "observations", "pixels"};
const std::vector<std::string> kFeatureColumns{"time_ns", "landmark", "u_left",
                                               "v_left",  "u_right",  "v_right"};
const std::vector<std::string> kLandmarkColumns{"landmark", "x", "y", "z"};

constexpr std::array kTables{
    "velocities.csv", "imu.csv",   "frames.csv",      "features.csv",
    "pixels.csv",     "truth.tum", "true_motion.csv", "landmarks_truth.csv"};

using Text = fmt::memory_buffer;
namespace fs = std::filesystem;

std::vector<BodyVelocity> read_velocities(const fs::path& file) {
  CsvReader csv(file, kVelocityColumns);
  std::vector<BodyVelocity> velocities;
  while (csv.next()) {
    const BodyVelocity row{.time = csv.time(0),
                           .linear_imu = {csv.finite(1), csv.finite(2), csv.finite(3)},
                           .angular_imu = {csv.finite(4), csv.finite(5), csv.finite(6)}};
    if (!velocities.empty()) check_rises(csv.where(0), velocities.back().time, row.time);
    velocities.push_back(row);
  }
  return velocities;
}

// The counts of a frame in frames.csv.
struct Counts {
  std::int64_t observations = 0, pixels = 0;
};

std::vector<FeatureFrame> read_frame_times(const fs::path& file, bool with_pixels,
                                           std::vector<Counts>& counts) {
  CsvReader csv(file, with_pixels ? kFramePixelColumns : kFrameColumns);
  std::vector<FeatureFrame> frames;
  while (csv.next()) {
    const Time time = csv.time(0);
    if (!frames.empty()) check_rises(csv.where(0), frames.back().time, time);
    frames.push_back({.time = time});
    counts.push_back({csv.integer(1), with_pixels ? csv.integer(2) : 0});
  }
  return frames;
}

// Adds the rows of features.csv, which are in order of time, to the frames.
void read_features(const fs::path& file, std::vector<FeatureFrame>& frames) {
  CsvReader csv(file, kFeatureColumns);
  FrameCursor cursor(frames);
  while (csv.next()) {
    FeatureFrame& frame = cursor.frame_of(csv);
    frame.observations.push_back(
        {.landmark = csv.integer(1),
         .pixels = {csv.finite(2), csv.finite(3), csv.finite(4), csv.finite(5)}});
  }
}

void check_count(const fs::path& file, Time time, std::size_t found, std::int64_t expected) {
  if (std::cmp_equal(found, expected)) return;
  throw InputError(fmt::format(
      "{}: holds {} observations of the frame at {} ns, expected {} as in frames.csv (is the "
      "file truncated?)",
      file.string(), found, time.count(), expected));
}

// Checks that a camera observes a landmark at most once in a frame.
void check_once(const fs::path& file, Time time, std::vector<std::pair<int, LandmarkId>>& seen) {
  std::sort(seen.begin(), seen.end());
  const auto twice = std::adjacent_find(seen.begin(), seen.end());
  if (twice == seen.end()) return;
  throw InputError(
      fmt::format("{}: landmark {} is there twice at {} ns, expected at most once{}", file.string(),
                  twice->second, time.count(),
                  twice->first < 0 ? std::string() : fmt::format(" in camera {}", twice->first)));
}

// Checks that no row is missing, and that no landmark is repeated.
void check_frames(const fs::path& folder, const std::vector<FeatureFrame>& frames,
                  const std::vector<Counts>& counts) {
  const fs::path features = folder / "features.csv", pixels = folder / "pixels.csv";
  std::vector<std::pair<int, LandmarkId>> seen;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    check_count(features, frames[k].time, frames[k].observations.size(), counts[k].observations);
    check_count(pixels, frames[k].time, frames[k].pixels.size(), counts[k].pixels);
    seen.clear();
    for (const StereoObservation& o : frames[k].observations) seen.emplace_back(-1, o.landmark);
    check_once(features, frames[k].time, seen);
    seen.clear();
    for (const PixelObservation& o : frames[k].pixels) seen.emplace_back(o.camera, o.landmark);
    check_once(pixels, frames[k].time, seen);
  }
}

std::vector<TrueLandmark> read_true_landmarks(const fs::path& file) {
  CsvReader csv(file, kLandmarkColumns);
  std::vector<TrueLandmark> landmarks;
  while (csv.next()) {
    landmarks.push_back(
        {.id = csv.integer(0), .p_world = {csv.finite(1), csv.finite(2), csv.finite(3)}});
  }
  return landmarks;
}

void write_velocities(const std::vector<BodyVelocity>& velocities, const fs::path& file) {
  Text rows;
  for (const BodyVelocity& row : velocities) {
    const Eigen::Vector3d &v = row.linear_imu, &w = row.angular_imu;
    fmt::format_to(std::back_inserter(rows), "{},{},{},{},{},{},{}\n", row.time.count(), v.x(),
                   v.y(), v.z(), w.x(), w.y(), w.z());
  }
  write_table(file, kVelocityColumns, {rows.data(), rows.size()});
}

void write_frames(const Recording& recording, const fs::path& file) {
  const bool with_pixels = !recording.cameras.empty();
  Text rows;
  for (const FeatureFrame& frame : recording.frames) {
    fmt::format_to(std::back_inserter(rows), "{},{}", frame.time.count(),
                   frame.observations.size());
    if (with_pixels) fmt::format_to(std::back_inserter(rows), ",{}", frame.pixels.size());
    rows.push_back('\n');
  }
  write_table(file, with_pixels ? kFramePixelColumns : kFrameColumns, {rows.data(), rows.size()});
}

void write_features(const std::vector<FeatureFrame>& frames, const fs::path& file) {
  Text rows;
  for (const FeatureFrame& frame : frames) {
    for (const StereoObservation& o : frame.observations) {
      fmt::format_to(std::back_inserter(rows), "{},{},{},{},{},{}\n", frame.time.count(),
                     o.landmark, o.pixels[0], o.pixels[1], o.pixels[2], o.pixels[3]);
    }
  }
  write_table(file, kFeatureColumns, {rows.data(), rows.size()});
}

void write_true_landmarks(const std::vector<TrueLandmark>& landmarks, const fs::path& file) {
  Text rows;
  for (const TrueLandmark& row : landmarks) {
    fmt::format_to(std::back_inserter(rows), "{},{},{},{}\n", row.id, row.p_world.x(),
                   row.p_world.y(), row.p_world.z());
  }
  write_table(file, kLandmarkColumns, {rows.data(), rows.size()});
}

// Rejects a file that the calibration does not mention; it would be ignored silently.
void reject(const fs::path& file, const std::string& missing) {
  if (!fs::exists(file)) return;
  throw InputError(
      fmt::format("{}: is there, but calibration.yaml has no {}: expected both or "
                  "neither",
                  file.string(), missing));
}

void read_motion_tables(const fs::path& folder, const FolderCalibration& calibration,
                        Recording& recording) {
  const fs::path imu = folder / "imu.csv", velocities = folder / "velocities.csv";
  if (calibration.imu_convention) {
    recording.imu = read_imu(imu);
    leave_out_not_finite(imu, recording);
  } else {
    reject(imu, "imu_convention");
  }
  if (!calibration.imu_convention || fs::exists(velocities)) {
    recording.velocities = read_velocities(velocities);
  }
}

// Tracks have one table of times for all cameras.
void reject_time_offsets(const fs::path& file, const FolderCalibration& calibration) {
  for (const Time offset : calibration.time_offsets) {
    if (offset == Time::zero()) continue;
    throw InputError(fmt::format(
        "{}: key 'timeshift_cam_imu' is {} s, expected it for images only: the times of tracks "
        "are those of frames.csv, by the IMU's clock",
        file.string(), to_seconds(offset)));
  }
}

void read_frame_tables(const fs::path& folder, const FolderCalibration& calibration,
                       Recording& recording) {
  const fs::path features = folder / "features.csv", pixels = folder / "pixels.csv";
  const std::size_t cameras = calibration.cameras.size();
  std::vector<Counts> counts;
  recording.frames = read_frame_times(folder / "frames.csv", cameras > 0, counts);
  if (calibration.rig) {
    read_features(features, recording.frames);
  } else {
    reject(features, "rig (fx, fy, cx, cy, baseline, cam0_T_imu)");
  }
  if (cameras > 0) {
    read_pixels(pixels, cameras, recording.frames);
  } else {
    reject(pixels, "cameras");
  }
  check_frames(folder, recording.frames, counts);
}

void read_truth_tables(const fs::path& folder, Recording& recording) {
  const fs::path truth = folder / "truth.tum", motion = folder / "true_motion.csv",
                 landmarks = folder / "landmarks_truth.csv";
  if (fs::exists(truth)) read_truth_of_recording(truth, recording);
  if (fs::exists(motion)) recording.true_motion = read_true_motion(motion, recording.truth);
  if (fs::exists(landmarks)) recording.true_landmarks = read_true_landmarks(landmarks);
}

bool has_rig(const Recording& recording) { return recording.rig.fx > 0; }
bool has_imu(const Recording& recording) { return !recording.imu.empty(); }

FolderCalibration calibration_of(const Recording& r) {
  FolderCalibration calibration{.name = r.name,
                                .cameras = r.cameras,
                                .remarks = r.remarks,
                                .velocity_sigma = r.velocity_sigma,
                                .pixel_sigma = r.pixel_sigma,
                                .single_pixel_sigma = r.single_pixel_sigma,
                                .imu_noise = r.imu_noise,
                                .imu_range = r.imu_range,
                                .truth_level = r.truth_level};
  if (has_rig(r)) calibration.rig = r.rig;
  if (has_imu(r)) calibration.imu_convention = r.imu_convention;
  return calibration;
}

}  // namespace

Recording read_folder_recording(const fs::path& folder) {
  const FolderCalibration calibration = read_calibration(folder / "calibration.yaml");
  Recording recording;
  recording.name = calibration.name;
  recording.rig = calibration.rig.value_or(StereoRig{});
  recording.cameras = calibration.cameras;
  recording.imu_convention = calibration.imu_convention.value_or(ImuConvention::kInstant);
  recording.imu_noise = calibration.imu_noise;
  recording.imu_range = calibration.imu_range;
  recording.velocity_sigma = calibration.velocity_sigma;
  recording.pixel_sigma = calibration.pixel_sigma;
  recording.single_pixel_sigma = calibration.single_pixel_sigma;
  recording.truth_level = calibration.truth_level;
  recording.remarks = calibration.remarks;
  reject_time_offsets(folder / "calibration.yaml", calibration);
  read_motion_tables(folder, calibration, recording);
  read_frame_tables(folder, calibration, recording);
  read_truth_tables(folder, recording);
  recording.plan = read_plan_of(folder);
  for (const char* table : kTables) remark_on_open_end(folder / table, recording.remarks);
  return recording;
}

void write_folder_recording(const Recording& recording, const fs::path& folder) {
  make_folder(folder);
  for (const char* table : kTables) remove_file(folder / table);
  write_plan_of(recording.plan, folder);
  write_calibration(calibration_of(recording), folder / "calibration.yaml");
  if (!recording.velocities.empty() || !has_imu(recording)) {
    write_velocities(recording.velocities, folder / "velocities.csv");
  }
  if (has_imu(recording)) write_imu(recording.imu, folder / "imu.csv");
  write_frames(recording, folder / "frames.csv");
  if (has_rig(recording)) write_features(recording.frames, folder / "features.csv");
  if (!recording.cameras.empty()) write_pixels(recording.frames, folder / "pixels.csv");
  if (!recording.truth.empty()) write_tum(recording.truth, folder / "truth.tum");
  if (!recording.true_motion.empty()) {
    write_true_motion(recording.true_motion, folder / "true_motion.csv");
  }
  if (!recording.true_landmarks.empty()) {
    write_true_landmarks(recording.true_landmarks, folder / "landmarks_truth.csv");
  }
}

}  // namespace chasles
