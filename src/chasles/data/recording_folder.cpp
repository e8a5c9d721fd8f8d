#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include <chasles/data/calibration.hpp>
#include <chasles/data/csv.hpp>
#include <chasles/data/numbers.hpp>
#include <chasles/data/readers.hpp>
#include <chasles/data/text_file.hpp>
#include <chasles/error.hpp>

namespace chasles {
namespace {

const std::vector<std::string> kVelocityColumns{"time_ns", "vx", "vy", "vz", "wx", "wy", "wz"};
const std::vector<std::string> kFrameColumns{"time_ns", "observations"};
const std::vector<std::string> kFeatureColumns{"time_ns", "landmark", "u_left",
                                               "v_left",  "u_right",  "v_right"};
const std::vector<std::string> kLandmarkColumns{"landmark", "x", "y", "z"};

using Text = fmt::memory_buffer;

void write_table(const std::filesystem::path& file, const std::vector<std::string>& columns,
                 const Text& rows) {
  std::string bytes = fmt::format("{}\n", fmt::join(columns, ","));
  bytes.append(rows.data(), rows.size());
  write_file(file, bytes);
}

std::vector<BodyVelocity> read_velocities(const std::filesystem::path& file) {
  CsvReader csv(file, kVelocityColumns);
  std::vector<BodyVelocity> velocities;
  while (csv.next()) {
    const BodyVelocity row{.time = Time(csv.integer(0)),
                           .linear_imu = {csv.finite(1), csv.finite(2), csv.finite(3)},
                           .angular_imu = {csv.finite(4), csv.finite(5), csv.finite(6)}};
    if (!velocities.empty()) check_rises(csv.where(0), velocities.back().time, row.time);
    velocities.push_back(row);
  }
  return velocities;
}

std::vector<FeatureFrame> read_frame_times(const std::filesystem::path& file,
                                           std::vector<std::int64_t>& counts) {
  CsvReader csv(file, kFrameColumns);
  std::vector<FeatureFrame> frames;
  while (csv.next()) {
    const Time time(csv.integer(0));
    if (!frames.empty()) check_rises(csv.where(0), frames.back().time, time);
    frames.push_back({.time = time, .observations = {}});
    counts.push_back(csv.integer(1));
  }
  return frames;
}

// Puts the rows of features.csv, which are in order of time, into the frames.
void read_features(const std::filesystem::path& file, std::vector<FeatureFrame>& frames) {
  CsvReader csv(file, kFeatureColumns);
  auto frame = frames.begin();
  while (csv.next()) {
    const Time time(csv.integer(0));
    while (frame != frames.end() && frame->time < time) ++frame;
    if (frame == frames.end() || frame->time != time) {
      throw InputError(fmt::format(
          "{}: {} is no frame of frames.csv at or after that of the row before, expected rows in "
          "order of time, each of a frame",
          csv.where(0), time.count()));
    }
    frame->observations.push_back(
        {.landmark = csv.integer(1),
         .pixels = {csv.finite(2), csv.finite(3), csv.finite(4), csv.finite(5)}});
  }
}

// A landmark is seen at most once in a frame, and no row was lost.
void check_frames(const std::filesystem::path& folder, const std::vector<FeatureFrame>& frames,
                  const std::vector<std::int64_t>& counts) {
  std::vector<LandmarkId> ids;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (std::cmp_not_equal(frames[k].observations.size(), counts[k])) {
      throw InputError(fmt::format(
          "{}: holds {} observations of the frame at {} ns, expected {} as frames.csv says (is the "
          "file truncated?)",
          (folder / "features.csv").string(), frames[k].observations.size(), frames[k].time.count(),
          counts[k]));
    }
    ids.clear();
    for (const StereoObservation& o : frames[k].observations) ids.push_back(o.landmark);
    std::sort(ids.begin(), ids.end());
    const auto twice = std::adjacent_find(ids.begin(), ids.end());
    if (twice == ids.end()) continue;
    throw InputError(fmt::format("{}: landmark {} is there twice at {} ns, expected at most once",
                                 (folder / "features.csv").string(), *twice,
                                 frames[k].time.count()));
  }
}

std::vector<TrueLandmark> read_true_landmarks(const std::filesystem::path& file) {
  CsvReader csv(file, kLandmarkColumns);
  std::vector<TrueLandmark> landmarks;
  while (csv.next()) {
    landmarks.push_back(
        {.id = csv.integer(0), .p_world = {csv.finite(1), csv.finite(2), csv.finite(3)}});
  }
  return landmarks;
}

void write_velocities(const std::vector<BodyVelocity>& velocities,
                      const std::filesystem::path& file) {
  Text rows;
  for (const BodyVelocity& row : velocities) {
    const Eigen::Vector3d &v = row.linear_imu, &w = row.angular_imu;
    fmt::format_to(std::back_inserter(rows), "{},{},{},{},{},{},{}\n", row.time.count(), v.x(),
                   v.y(), v.z(), w.x(), w.y(), w.z());
  }
  write_table(file, kVelocityColumns, rows);
}

void write_frames(const std::vector<FeatureFrame>& frames, const std::filesystem::path& folder) {
  Text times, features;
  for (const FeatureFrame& frame : frames) {
    fmt::format_to(std::back_inserter(times), "{},{}\n", frame.time.count(),
                   frame.observations.size());
    for (const StereoObservation& o : frame.observations) {
      fmt::format_to(std::back_inserter(features), "{},{},{},{},{},{}\n", frame.time.count(),
                     o.landmark, o.pixels[0], o.pixels[1], o.pixels[2], o.pixels[3]);
    }
  }
  write_table(folder / "frames.csv", kFrameColumns, times);
  write_table(folder / "features.csv", kFeatureColumns, features);
}

void write_true_landmarks(const std::vector<TrueLandmark>& landmarks,
                          const std::filesystem::path& file) {
  Text rows;
  for (const TrueLandmark& row : landmarks) {
    fmt::format_to(std::back_inserter(rows), "{},{},{},{}\n", row.id, row.p_world.x(),
                   row.p_world.y(), row.p_world.z());
  }
  write_table(file, kLandmarkColumns, rows);
}

}  // namespace

Recording read_folder_recording(const std::filesystem::path& folder) {
  const Calibration calibration = read_calibration(folder / "calibration.yaml");
  Recording recording{.name = calibration.name,
                      .rig = calibration.rig,
                      .velocities = read_velocities(folder / "velocities.csv"),
                      .frames = {},
                      .truth = {},
                      .true_landmarks = {},
                      .velocity_sigma = calibration.velocity_sigma,
                      .pixel_sigma = calibration.pixel_sigma,
                      .remarks = calibration.remarks};
  std::vector<std::int64_t> counts;
  recording.frames = read_frame_times(folder / "frames.csv", counts);
  read_features(folder / "features.csv", recording.frames);
  check_frames(folder, recording.frames, counts);
  if (std::filesystem::exists(folder / "truth.tum")) {
    recording.truth = read_tum(folder / "truth.tum");
  }
  if (std::filesystem::exists(folder / "landmarks_truth.csv")) {
    recording.true_landmarks = read_true_landmarks(folder / "landmarks_truth.csv");
  }
  return recording;
}

void write_folder_recording(const Recording& recording, const std::filesystem::path& folder) {
  make_folder(folder);
  write_calibration({.name = recording.name,
                     .rig = recording.rig,
                     .remarks = recording.remarks,
                     .velocity_sigma = recording.velocity_sigma,
                     .pixel_sigma = recording.pixel_sigma},
                    folder / "calibration.yaml");
  write_velocities(recording.velocities, folder / "velocities.csv");
  write_frames(recording.frames, folder);
  remove_file(folder / "truth.tum");
  remove_file(folder / "landmarks_truth.csv");
  if (!recording.truth.empty()) write_tum(recording.truth, folder / "truth.tum");
  if (!recording.true_landmarks.empty()) {
    write_true_landmarks(recording.true_landmarks, folder / "landmarks_truth.csv");
  }
}

}  // namespace chasles
