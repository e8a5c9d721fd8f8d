#include <set>
#include <string>
#include <utility>

#include <fmt/format.h>

#include <chasles/base/error.hpp>
#include <chasles/codec/csv.hpp>
#include <chasles/codec/gzip.hpp>
#include <chasles/codec/numbers.hpp>
#include <chasles/recording/euroc_tables.hpp>
#include <chasles/recording/readers.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kFirstColumns = "#timestamp [ns],track_id,u";
constexpr std::string_view kNameEnding = "_klt_tracks_cam0";

// cam0 of EuRoC's sensor, which recorded all eleven sequences, from their cam0/sensor.yaml (Burri
// et al. 2016).
Camera euroc_cam0() {
  Eigen::Matrix3d R;
  R << 0.0148655429818, -0.999880929698, 0.00414029679422,  //
      0.999557249008, 0.0149672133247, 0.025715529948,      //
      -0.0257744366974, 0.00375618835797, 0.999660727178;
  const SE3 imu_T_cam{so3::normalized(R), {-0.0216401454975, -0.064676986768, 0.00981073058949}};
  return {.width = 752,
          .height = 480,
          .fx = 458.654,
          .fy = 457.296,
          .cx = 367.215,
          .cy = 248.375,
          .distortion = Distortion::kRadtan,
          .coefficients = {-0.28340811, 0.07395907, 0.00019359, 1.76187114e-05},
          .cam_T_imu = imu_T_cam.inverse()};
}

constexpr ImuNoise kEurocNoise{.accelerometer_noise_density = 2e-3,
                               .accelerometer_random_walk = 3e-3,
                               .gyroscope_noise_density = 1.6968e-4,
                               .gyroscope_random_walk = 1.9393e-5};

// MH_01_easy from MH_01_easy_klt_tracks_cam0.csv.gz.
std::string klt_sequence_of(const fs::path& file) {
  const std::string name = file.filename().string();
  const std::size_t at = name.find(kNameEnding);
  if (at != std::string::npos) return name.substr(0, at);
  throw InputError(
      fmt::format("{}: expected a name SEQUENCE{}.csv, which determines the name of the samples "
                  "beside it: SEQUENCE_imu.csv",
                  file.string(), kNameEnding));
}

fs::path samples_beside(const fs::path& file, const std::string& sequence) {
  for (const char* ending : {"_imu.csv", "_imu.csv.gz"}) {
    const fs::path samples = file.parent_path() / (sequence + ending);
    if (fs::exists(samples)) return samples;
  }
  throw InputError(
      fmt::format("{}: there is no {}_imu.csv (or .csv.gz) beside it, expected the "
                  "samples of the IMU there",
                  file.string(), sequence));
}

void check_in_image(const CsvReader& csv, const Camera& camera, const Eigen::Vector2d& pixel) {
  if (in_image(camera, pixel, -1)) return;  // a tracker may follow a patch that is half outside
  throw InputError(fmt::format("{}: pixel ({}, {}) lies outside the image of {} x {} px",
                               csv.where(2), pixel.x(), pixel.y(), camera.width, camera.height));
}

std::vector<FeatureFrame> read_tracks(const fs::path& file, const Camera& camera) {
  CsvReader csv(file.string(), read_plain_or_gzip(file), {{"timestamp", "track_id", "u", "v"}});
  std::vector<FeatureFrame> frames;
  std::set<LandmarkId> seen;
  while (csv.next()) {
    const Time time = csv.time(0);
    if (frames.empty() || time != frames.back().time) {
      if (!frames.empty()) check_rises(csv.where(0), frames.back().time, time);
      frames.push_back({.time = time});
      seen.clear();
    }
    const PixelObservation row{
        .landmark = csv.integer(1), .camera = 0, .pixel = {csv.finite(2), csv.finite(3)}};
    check_in_image(csv, camera, row.pixel);
    if (!seen.insert(row.landmark).second) {
      throw InputError(fmt::format("{}: track {} is there twice at {} ns, expected at most once",
                                   csv.where(1), row.landmark, time.count()));
    }
    frames.back().pixels.push_back(row);
  }
  csv.require_whole();
  return frames;
}

}  // namespace

bool begins_klt_tracks(std::string_view bytes) { return bytes.starts_with(kFirstColumns); }

Recording read_klt_tracks_recording(const fs::path& file) {
  const std::string sequence = klt_sequence_of(file);
  Recording recording = read_euroc_imu_recording(samples_beside(file, sequence));
  recording.name = sequence + "_tracks";
  const fs::path sensor = file.parent_path() / "cam0_sensor.yaml";
  if (fs::exists(sensor)) {
    recording.cameras = {read_euroc_camera_of_tracks(sensor)};
  } else {
    recording.cameras = {euroc_cam0()};
    recording.remarks.push_back(
        "there is no cam0_sensor.yaml beside the tracks: the calibration of EuRoC's cam0 is taken");
  }
  recording.imu_noise = kEurocNoise;
  recording.frames = read_tracks(file, recording.cameras[0]);
  if (!recording.frames.empty()) return recording;
  throw InputError(file.string() + ": holds no track, expected rows `time,track,u,v`");
}

}  // namespace chasles
