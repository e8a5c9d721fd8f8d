#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>
#include <zip.h>

#include <gtest/gtest.h>

#include <chasles/base/error.hpp>
#include <chasles/lie/testing.hpp>
#include <chasles/recording/recording.hpp>

// Shared by the tests of this folder.
namespace chasles::test {

/// An empty folder for the running test alone.
inline std::filesystem::path scratch() {
  const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) /
                                       "chasles_data_test" / info->test_suite_name() / info->name();
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  return folder;
}

/// The folder of the real recordings, if available.
inline std::optional<std::filesystem::path> recordings() {
  const char* given = std::getenv("CHASLES_DATA");
  const std::filesystem::path folder =
      given ? given : std::filesystem::path(CHASLES_SOURCE_DIR) / ".." / "shared" / "data";
  if (!std::filesystem::exists(folder / "kitti_tracks")) return std::nullopt;
  return folder / "kitti_tracks";
}

inline std::string slurp(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream bytes;
  bytes << stream.rdbuf();
  return bytes.str();
}

inline void spill(const std::filesystem::path& file, const std::string& bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
}

/// The message of the InputError that the call throws. The test fails if it throws none.
template <typename Call>
std::string input_error(Call call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  ADD_FAILURE() << "expected an InputError, and there was none";
  return "";
}

/// Fails unless the message holds each of the parts.
inline void expect_parts(const std::string& message, const std::vector<std::string>& parts) {
  for (const std::string& part : parts) {
    EXPECT_NE(message.find(part), std::string::npos) << "no '" << part << "' in: " << message;
  }
}

/// A field of an .npz file: values with the last index fastest, and their storage format.
struct NpyField {
  std::vector<std::size_t> shape;
  std::vector<double> values;
  std::string descr = "<f8";
  bool fortran_order = false;
  char version = 1;
};

template <typename Number>
void append_raw(std::string& bytes, double value) {
  const auto number = static_cast<Number>(value);
  char raw[sizeof(Number)];
  std::memcpy(raw, &number, sizeof(Number));
  bytes.append(raw, sizeof(Number));
}

/// The .npy header with its preamble, as numpy writes it.
inline std::string npy_header(const std::string& dict, char version = 1) {
  std::string text = dict;
  while ((text.size() + (version == 1 ? 11 : 13)) % 64 != 0) text += ' ';
  text += '\n';
  std::string header = "\x93NUMPY";
  header += version;
  header += '\0';
  const std::size_t size = text.size();
  header += static_cast<char>(size & 255);
  header += static_cast<char>(size >> 8);
  if (version > 1) header += std::string(2, '\0');
  return header + text;
}

inline std::string npy_bytes(const NpyField& field) {
  std::string shape;
  for (const std::size_t size : field.shape) shape += std::to_string(size) + ", ";
  std::string bytes =
      npy_header("{'descr': '" + field.descr + "', 'fortran_order': " +
                     (field.fortran_order ? "True" : "False") + ", 'shape': (" + shape + "), }",
                 field.version);
  for (std::size_t i = 0; i < field.values.size(); ++i) {
    std::size_t flat = i;
    if (field.fortran_order) {  // i counts with the first index fastest
      std::size_t rest = i;
      flat = 0;
      std::vector<std::size_t> index;
      for (const std::size_t size : field.shape) {
        index.push_back(rest % size);
        rest /= size;
      }
      for (std::size_t a = 0; a < index.size(); ++a) flat = flat * field.shape[a] + index[a];
    }
    const double value = field.values[flat];
    if (field.descr == "<f4")
      append_raw<float>(bytes, value);
    else if (field.descr == "<i4")
      append_raw<std::int32_t>(bytes, value);
    else if (field.descr == "<i8")
      append_raw<std::int64_t>(bytes, value);
    else
      append_raw<double>(bytes, value);
  }
  return bytes;
}

inline void write_zip(const std::filesystem::path& file,
                      const std::vector<std::pair<std::string, std::string>>& entries) {
  int code = 0;
  zip_t* archive = zip_open(file.c_str(), ZIP_CREATE | ZIP_TRUNCATE, &code);
  ASSERT_NE(archive, nullptr);
  for (const auto& [name, bytes] : entries) {
    zip_source_t* source = zip_source_buffer(archive, bytes.data(), bytes.size(), 0);
    ASSERT_GE(zip_file_add(archive, name.c_str(), source, ZIP_FL_OVERWRITE), 0);
  }
  ASSERT_EQ(zip_close(archive), 0);
}

using NpzFields = std::map<std::string, NpyField>;

inline void write_npz(const std::filesystem::path& file, const NpzFields& fields) {
  std::vector<std::pair<std::string, std::string>> entries;
  for (const auto& [name, field] : fields) entries.emplace_back(name + ".npy", npy_bytes(field));
  write_zip(file, entries);
}

/// Standard axes: camera x = -y of the body, y = -z, z = x.
inline SE3 proper_cam0_T_imu(const Eigen::Vector3d& rho) {
  Eigen::Matrix3d C;
  C << 0, -1, 0, 0, 0, -1, 1, 0, 0;
  return {C, -(C * rho)};
}

inline const Eigen::Vector3d kRho(1.1, -0.3, 0.7);

/// A car with constant velocities that observes landmarks without error.
struct Drive {
  double speed = 8;         ///< [m/s]
  double yaw_rate = 0.4;    ///< [rad/s]
  std::size_t frames = 60;  ///< at 10 Hz
  std::size_t tracks = 200;
  double speed_noise = 0;  ///< of the measured velocities, each axis [m/s]
  double rate_noise = 0;   ///< [rad/s]
};

inline Recording drive(const Drive& settings) {
  Random random(7);
  Recording r;
  r.name = "drive";
  r.rig = {.fx = 700,
           .fy = 700,
           .cx = 600,
           .cy = 180,
           .baseline = 0.54,
           .cam0_T_imu = proper_cam0_T_imu(kRho)};
  Vector6d twist;
  twist << 0, 0, settings.yaw_rate, settings.speed, 0, 0;
  for (std::size_t k = 0; k < settings.frames; ++k) {
    const double seconds = 0.1 * static_cast<double>(k);
    r.truth.push_back({.time = from_seconds(seconds), .pose = se3::exp(twist * seconds)});
    BodyVelocity& u = r.velocities.emplace_back();
    u.time = r.truth.back().time;
    u.linear_imu = twist.tail<3>();
    u.angular_imu = twist.head<3>();
    for (int axis = 0; axis < 3; ++axis) {
      u.linear_imu[axis] += settings.speed_noise * random.normal();
      u.angular_imu[axis] += settings.rate_noise * random.normal();
    }
    r.frames.push_back({.time = u.time, .observations = {}});
  }
  for (std::size_t j = 0; j < settings.tracks; ++j) {
    const StampedPose& near = r.truth[j * settings.frames / settings.tracks];
    r.true_landmarks.push_back(
        {.id = static_cast<LandmarkId>(j),
         .p_world = near.pose * Eigen::Vector3d(random.uniform(10, 25), random.uniform(-8, 8),
                                                random.uniform(-2, 4))});
    for (std::size_t k = 0; k < settings.frames; ++k) {
      const SE3 cam0_T_world = r.rig.cam0_T_imu * r.truth[k].pose.inverse();
      const auto seen = project(r.rig, cam0_T_world * r.true_landmarks.back().p_world);
      if (!seen || seen->pixels.minCoeff() < 0 || seen->pixels[0] > 1200) continue;
      if (seen->pixels[1] > 370 || seen->pixels[0] - seen->pixels[2] < 8) continue;
      r.frames[k].observations.push_back(
          {.landmark = static_cast<LandmarkId>(j), .pixels = seen->pixels});
    }
  }
  return r;
}

/// The index of component `pixel` of a track in a frame, in an array (4, tracks, frames).
inline std::size_t feature_at(const NpyField& features, std::size_t pixel, std::size_t track,
                              std::size_t frame) {
  return (pixel * features.shape[1] + track) * features.shape[2] + frame;
}

/// The fields of an ECE276A archive of the recording, with the malformed cam_T_imu = [C | rho].
inline NpzFields npz_fields(const Recording& r, std::size_t tracks) {
  const std::size_t T = r.frames.size();
  NpzFields fields;
  NpyField &t = fields["time_stamps"], &v = fields["linear_velocity"],
           &w = fields["rotational_velocity"], &f = fields["features"], &M = fields["cam_T_imu"];
  t.shape = {1, T};
  v = w = {.shape = {3, T}, .values = std::vector<double>(3 * T)};
  f = {.shape = {4, tracks, T}, .values = std::vector<double>(4 * tracks * T, -1)};
  for (std::size_t k = 0; k < T; ++k) {
    t.values.push_back(1e9 + to_seconds(r.frames[k].time));
    for (std::size_t axis = 0; axis < 3; ++axis) {
      v.values[axis * T + k] = r.velocities[k].linear_imu[static_cast<int>(axis)];
      w.values[axis * T + k] = r.velocities[k].angular_imu[static_cast<int>(axis)];
    }
    for (const StereoObservation& o : r.frames[k].observations) {
      for (std::size_t pixel = 0; pixel < 4; ++pixel) {
        f.values[feature_at(f, pixel, static_cast<std::size_t>(o.landmark), k)] =
            o.pixels[static_cast<int>(pixel)];
      }
    }
  }
  fields["K"] = {.shape = {3, 3},
                 .values = {r.rig.fx, 0, r.rig.cx, 0, r.rig.fy, r.rig.cy, 0, 0, 1}};
  fields["b"] = {.shape = {}, .values = {r.rig.baseline}};
  M = {.shape = {4, 4},
       .values = {0, -1, 0, kRho[0], 0, 0, -1, kRho[1], 1, 0, 0, kRho[2], 0, 0, 0, 1}};
  return fields;
}

}  // namespace chasles::test
