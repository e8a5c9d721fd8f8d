#include <concepts>
#include <limits>
#include <memory>
#include <new>
#include <stdexcept>

#include <sqlite3.h>

#include <chasles/calibration/colmap_lens.hpp>
#include <chasles/viewers/byte_sink.hpp>
#include <chasles/viewers/colmap_rig.hpp>

namespace chasles {
namespace {

// The columns of COLMAP 4.2's tables; user_version is that of their scheme.
constexpr const char* kTables = R"(
PRAGMA user_version = 4020100;
CREATE TABLE cameras(camera_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, model INTEGER NOT NULL,
  width INTEGER NOT NULL, height INTEGER NOT NULL, params BLOB,
  prior_focal_length INTEGER NOT NULL);
CREATE TABLE rigs(rig_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
  ref_sensor_id INTEGER NOT NULL, ref_sensor_type INTEGER NOT NULL);
CREATE TABLE rig_sensors(rig_id INTEGER NOT NULL, sensor_id INTEGER NOT NULL,
  sensor_type INTEGER NOT NULL, sensor_from_rig BLOB,
  FOREIGN KEY(rig_id) REFERENCES rigs(rig_id) ON DELETE CASCADE);
CREATE TABLE frames(frame_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, rig_id INTEGER NOT NULL,
  FOREIGN KEY(rig_id) REFERENCES rigs(rig_id) ON DELETE CASCADE);
CREATE TABLE frame_data(frame_id INTEGER NOT NULL, data_id INTEGER NOT NULL,
  sensor_id INTEGER NOT NULL, sensor_type INTEGER NOT NULL,
  FOREIGN KEY(frame_id) REFERENCES frames(frame_id) ON DELETE CASCADE);
CREATE TABLE images(image_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL,
  name TEXT NOT NULL UNIQUE, camera_id INTEGER NOT NULL,
  CHECK(image_id >= 0 AND image_id < 2147483647),
  FOREIGN KEY(camera_id) REFERENCES cameras(camera_id));
CREATE TABLE pose_priors(pose_prior_id INTEGER PRIMARY KEY NOT NULL,
  corr_data_id INTEGER NOT NULL, corr_sensor_id INTEGER NOT NULL,
  corr_sensor_type INTEGER NOT NULL, position BLOB, position_covariance BLOB, gravity BLOB,
  coordinate_system INTEGER NOT NULL);
)";

constexpr int kCartesian = 1;  // of coordinate_system: not longitude and latitude
// As COLMAP has it in a prior.
const Eigen::Vector3d kNotKnown =
    Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());

using OpenDatabase = std::unique_ptr<sqlite3, decltype(&sqlite3_close)>;
using OpenStatement = std::unique_ptr<sqlite3_stmt, decltype(&sqlite3_finalize)>;

// SQLite in memory: an error is one of this file.
void check(int result, sqlite3* database) {
  if (result != SQLITE_OK) throw std::logic_error(sqlite3_errmsg(database));
}

OpenDatabase empty_database() {
  sqlite3* opened = nullptr;
  const int result = sqlite3_open(":memory:", &opened);
  OpenDatabase database(opened, &sqlite3_close);
  check(result, opened);
  check(sqlite3_exec(opened, kTables, nullptr, nullptr, nullptr), opened);
  return database;
}

template <typename Numbers>
std::string blob_of(const Numbers& numbers) {
  std::string bytes;
  for (const double number : numbers) append_little_endian(bytes, number);
  return bytes;
}

// Appends rows to a table.
class Rows {
 public:
  Rows(sqlite3* database, const char* insertion)
      : database_(database), statement_(nullptr, &sqlite3_finalize) {
    sqlite3_stmt* prepared = nullptr;
    check(sqlite3_prepare_v2(database, insertion, -1, &prepared, nullptr), database);
    statement_.reset(prepared);
  }

  // Integers, texts by const char*, and blobs.
  template <typename... Values>
  void add(const Values&... values) {
    int place = 0;
    (bind(++place, values), ...);
    if (sqlite3_step(statement_.get()) != SQLITE_DONE) check(SQLITE_ERROR, database_);
    check(sqlite3_reset(statement_.get()), database_);
  }

 private:
  template <std::integral Integer>
  void bind(int place, Integer value) {
    check(sqlite3_bind_int64(statement_.get(), place, static_cast<sqlite3_int64>(value)),
          database_);
  }
  void bind(int place, const char* text) {
    check(sqlite3_bind_text(statement_.get(), place, text, -1, SQLITE_TRANSIENT), database_);
  }
  void bind(int place, const std::string& blob) {
    check(sqlite3_bind_blob(statement_.get(), place, blob.data(), static_cast<int>(blob.size()),
                            SQLITE_TRANSIENT),
          database_);
  }

  sqlite3* database_;
  OpenStatement statement_;
};

void add_cameras(const ColmapModel& model, sqlite3* database) {
  Rows cameras(database, "INSERT INTO cameras VALUES(?, ?, ?, ?, ?, 1)");
  Rows rigs(database, "INSERT INTO rigs VALUES(?, ?, ?)");
  Rows sensors(database, "INSERT INTO rig_sensors VALUES(?, ?, ?, ?)");
  rigs.add(kColmapRig, colmap_id(0), kColmapCamera);
  for (std::size_t i = 0; i < model.cameras.size(); ++i) {
    const Camera& camera = model.cameras[i];
    const ColmapLens lens = colmap_lens(camera);
    cameras.add(colmap_id(i), lens.id, camera.width, camera.height, blob_of(lens.parameters));
    if (i == 0) continue;
    sensors.add(kColmapRig, colmap_id(i), kColmapCamera,
                blob_of(colmap_pose(camera_T_first(model, i))));
  }
}

// Of a camera's position: that of the IMU with the lever arm, which the error of the attitude
// turns.
Eigen::Matrix3d position_covariance(const ColmapFrame& frame, const Eigen::Vector3d& p_imu) {
  Eigen::Matrix<double, 3, 6> J;
  J << -hat(frame.world_T_imu.R * p_imu), Eigen::Matrix3d::Identity();
  return J * frame.pose_covariance * J.transpose();
}

void add_images(const ColmapModel& model, sqlite3* database) {
  Rows frames(database, "INSERT INTO frames VALUES(?, ?)");
  Rows data(database, "INSERT INTO frame_data VALUES(?, ?, ?, ?)");
  Rows images(database, "INSERT INTO images VALUES(?, ?, ?)");
  Rows priors(database, "INSERT INTO pose_priors VALUES(?, ?, ?, ?, ?, ?, ?, ?)");
  std::uint32_t id = 0;
  for (std::size_t i = 0; i < model.frames.size(); ++i) {
    const ColmapFrame& frame = model.frames[i];
    frames.add(colmap_id(i), kColmapRig);
    for (const ColmapImage& image : frame.images) {
      const std::uint32_t camera = colmap_id(image.camera);
      images.add(++id, image.name.c_str(), camera);
      data.add(colmap_id(i), id, camera, kColmapCamera);
      const SE3 world_T_cam = world_T_camera(model, frame, image.camera);
      const Eigen::Vector3d p_imu = model.cameras[image.camera].cam_T_imu.inverse().p;
      const Eigen::Matrix3d covariance = position_covariance(frame, p_imu);
      const Eigen::Vector3d down_cam = -world_T_cam.R.transpose().col(2);
      priors.add(id, id, camera, kColmapCamera, blob_of(world_T_cam.p),
                 blob_of(covariance.reshaped()), blob_of(model.is_level ? down_cam : kNotKnown),
                 kCartesian);
    }
  }
}

}  // namespace

std::string colmap_database(const ColmapModel& model) {
  const OpenDatabase database = empty_database();
  check(sqlite3_exec(database.get(), "BEGIN", nullptr, nullptr, nullptr), database.get());
  add_cameras(model, database.get());
  add_images(model, database.get());
  check(sqlite3_exec(database.get(), "COMMIT", nullptr, nullptr, nullptr), database.get());
  sqlite3_int64 size = 0;
  const std::unique_ptr<unsigned char, decltype(&sqlite3_free)> bytes(
      sqlite3_serialize(database.get(), "main", &size, 0), &sqlite3_free);
  if (!bytes) throw std::bad_alloc();
  return {reinterpret_cast<const char*>(bytes.get()), static_cast<std::size_t>(size)};
}

}  // namespace chasles
