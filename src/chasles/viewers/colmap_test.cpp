#include <cmath>
#include <cstring>
#include <sstream>
#include <string>
#include <tuple>

#include <gtest/gtest.h>
#include <sqlite3.h>

#include <chasles/base/error.hpp>
#include <chasles/calibration/colmap_lens.hpp>
#include <chasles/lie/so3.hpp>
#include <chasles/viewers/colmap.hpp>

namespace chasles {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

Camera pinhole(const SE3& cam_T_imu) {
  return {.width = 640,
          .height = 480,
          .fx = 500,
          .fy = 510,
          .cx = 319.5,
          .cy = 239.5,
          .distortion = Distortion::kNone,
          .coefficients = {},
          .cam_T_imu = cam_T_imu};
}

// Two cameras on a body at (1, 2, 3) that sees a point with both, and later with the second alone.
ColmapModel two_frames() {
  const SE3 cam0_T_imu{so3::exp({0.1, -0.2, 0.3}), {0.01, 0.02, 0.03}};
  const SE3 cam1_T_imu{so3::exp({0.1, -0.1, 0.3}), {-0.1, 0.02, 0.03}};
  ColmapModel model{.cameras = {pinhole(cam0_T_imu), pinhole(cam1_T_imu)}, .is_level = true};
  const SE3 first{so3::exp({0, 0.2, 1}), {1, 2, 3}}, second{so3::exp({0, 0.3, 1}), {1.2, 2, 3}};
  const Vector3d p_cam0(0.3, -0.2, 4);
  const Vector3d p_world = first * (cam0_T_imu.inverse() * p_cam0);
  model.points = {{.p_world = p_world, .error = 0.25, .grey = 77}};
  const auto seen = [&](const SE3& pose, std::size_t camera) {
    const auto p = project(model.cameras[camera],
                           model.cameras[camera].cam_T_imu * (pose.inverse() * p_world));
    return ColmapObservation{.pixel = p.value().pixel, .point = 0};
  };
  ColmapFrame a{.world_T_imu = first}, b{.world_T_imu = second};
  a.pose_covariance.diagonal() << 1e-4, 2e-4, 3e-4, 4e-4, 5e-4, 6e-4;
  a.pose_covariance(0, 5) = a.pose_covariance(5, 0) = 1e-4;
  a.images = {{.camera = 0, .name = "cam0/1.png", .observations = {seen(first, 0)}},
              {.camera = 1, .name = "cam1/1.png", .observations = {seen(first, 1)}}};
  b.images = {{.camera = 1, .name = "cam1/2.png", .observations = {seen(second, 1)}}};
  model.frames = {a, b};
  return model;
}

const std::string& file_of(const ColmapFiles& files, const std::string& name) {
  for (const auto& [file, bytes] : files) {
    if (file == name) return bytes;
  }
  throw std::runtime_error(name);
}

// The lines without comments.
std::vector<std::vector<std::string>> rows_of(const std::string& text) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with('#')) continue;
    std::istringstream words(line);
    auto& row = rows.emplace_back();
    for (std::string word; words >> word;) row.push_back(word);
  }
  return rows;
}

double colmap_number(const std::string& text) { return std::stod(text); }

// q and t of a row, by the textbook's matrix of a quaternion.
SE3 pose_of(const std::vector<std::string>& row, std::size_t at) {
  const double w = colmap_number(row[at]), x = colmap_number(row[at + 1]),
               y = colmap_number(row[at + 2]), z = colmap_number(row[at + 3]);
  SE3 pose;
  pose.R << 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),  //
      2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),        //
      2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y);
  pose.p << colmap_number(row[at + 4]), colmap_number(row[at + 5]), colmap_number(row[at + 6]);
  return pose;
}

TEST(Colmap, APoseMapsTheWorldToTheCameraAndTheCornerIsTheOriginOfThePixels) {
  const ColmapFiles files = colmap_text(two_frames());
  const auto cameras = rows_of(file_of(files, "cameras.txt"));
  ASSERT_EQ(cameras.size(), 2);
  EXPECT_EQ(cameras[0],
            (std::vector<std::string>{"1", "PINHOLE", "640", "480", "500", "510", "320", "240"}));
  const auto points = rows_of(file_of(files, "points3D.txt"));
  ASSERT_EQ(points.size(), 1);
  const Vector3d p_world(colmap_number(points[0][1]), colmap_number(points[0][2]),
                         colmap_number(points[0][3]));
  EXPECT_EQ(points[0][4], "77");
  EXPECT_EQ(colmap_number(points[0][7]), 0.25);
  const auto images = rows_of(file_of(files, "images.txt"));
  ASSERT_EQ(images.size(), 6);
  for (std::size_t i = 0; i < images.size(); i += 2) {
    const auto& camera = cameras[std::stoul(images[i][8]) - 1];
    const Vector3d p_cam = pose_of(images[i], 1) * p_world;
    EXPECT_GT(p_cam.z(), 3);
    const auto& pixel = images[i + 1];
    ASSERT_EQ(pixel.size(), 3);
    EXPECT_NEAR(colmap_number(camera[4]) * p_cam.x() / p_cam.z() + colmap_number(camera[6]),
                colmap_number(pixel[0]), 1e-9);
    EXPECT_NEAR(colmap_number(camera[5]) * p_cam.y() / p_cam.z() + colmap_number(camera[7]),
                colmap_number(pixel[1]), 1e-9);
    EXPECT_EQ(pixel[2], "1");
  }
  // The track of the point.
  EXPECT_EQ(std::vector(points[0].begin() + 8, points[0].end()),
            (std::vector<std::string>{"1", "0", "2", "0", "3", "0"}));
}

TEST(Colmap, TheRigGivesThePosesOfAllImages) {
  const ColmapFiles files = colmap_text(two_frames());
  const auto rig = rows_of(file_of(files, "rigs.txt")).at(0);
  EXPECT_EQ(std::vector(rig.begin(), rig.begin() + 7),
            (std::vector<std::string>{"1", "2", "CAMERA", "1", "CAMERA", "2", "1"}));
  const SE3 cam1_T_rig = pose_of(rig, 7);
  const auto frames = rows_of(file_of(files, "frames.txt"));
  const auto images = rows_of(file_of(files, "images.txt"));
  ASSERT_EQ(frames.size(), 2);
  EXPECT_EQ(std::vector(frames[0].begin() + 9, frames[0].end()),
            (std::vector<std::string>{"2", "CAMERA", "1", "1", "CAMERA", "2", "2"}));
  EXPECT_EQ(std::vector(frames[1].begin() + 9, frames[1].end()),
            (std::vector<std::string>{"1", "CAMERA", "2", "3"}));
  const SE3 first = pose_of(frames[0], 2), second = pose_of(frames[1], 2);
  const auto expect_near = [](const SE3& a, const SE3& b) {
    EXPECT_LT((a.R - b.R).norm() + (a.p - b.p).norm(), 1e-12);
  };
  expect_near(first, pose_of(images[0], 1));
  expect_near(cam1_T_rig * first, pose_of(images[2], 1));
  expect_near(cam1_T_rig * second, pose_of(images[4], 1));
}

// Reads little-endian numbers one after the other.
class Reader {
 public:
  explicit Reader(const std::string& bytes) : bytes_(bytes) {}
  template <typename Number>
  Number next() {
    Number value{};
    std::memcpy(&value, bytes_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  std::string text() {
    const std::string found = bytes_.c_str() + at_;
    at_ += found.size() + 1;
    return found;
  }
  bool at_end() const { return at_ == bytes_.size(); }

 private:
  const std::string& bytes_;
  std::size_t at_ = 0;
};

TEST(Colmap, TheBinaryImagesHaveTheNumbersOfTheText) {
  const ColmapModel model = two_frames();
  const auto rows = rows_of(file_of(colmap_text(model), "images.txt"));
  const ColmapFiles files = colmap_binary(model);
  Reader images(file_of(files, "images.bin"));
  ASSERT_EQ(images.next<std::uint64_t>(), 3);
  for (std::size_t i = 0; i < rows.size(); i += 2) {
    EXPECT_EQ(images.next<std::uint32_t>(), std::stoul(rows[i][0]));
    for (std::size_t k = 1; k < 8; ++k) EXPECT_EQ(images.next<double>(), colmap_number(rows[i][k]));
    EXPECT_EQ(images.next<std::uint32_t>(), std::stoul(rows[i][8]));
    EXPECT_EQ(images.text(), rows[i][9]);
    ASSERT_EQ(images.next<std::uint64_t>(), 1);
    for (std::size_t k = 0; k < 2; ++k)
      EXPECT_EQ(images.next<double>(), colmap_number(rows[i + 1][k]));
    EXPECT_EQ(images.next<std::uint64_t>(), 1);
  }
  EXPECT_TRUE(images.at_end());
  Reader points(file_of(files, "points3D.bin"));
  EXPECT_EQ(points.next<std::uint64_t>(), 1);
  EXPECT_EQ(points.next<std::uint64_t>(), 1);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(points.next<double>(), model.points[0].p_world(k));
  for (int k = 0; k < 3; ++k) EXPECT_EQ(points.next<std::uint8_t>(), 77);
  EXPECT_EQ(points.next<double>(), 0.25);
  EXPECT_EQ(points.next<std::uint64_t>(), 3);
}

// The doubles of a blob.
std::vector<double> blob_at(const std::string& bytes, const char* query) {
  sqlite3* database = nullptr;
  sqlite3_open(":memory:", &database);
  auto* data = reinterpret_cast<unsigned char*>(const_cast<char*>(bytes.data()));
  const auto size = static_cast<sqlite3_int64>(bytes.size());
  sqlite3_deserialize(database, "main", data, size, size, SQLITE_DESERIALIZE_READONLY);
  sqlite3_stmt* row = nullptr;
  EXPECT_EQ(sqlite3_prepare_v2(database, query, -1, &row, nullptr), SQLITE_OK);
  EXPECT_EQ(sqlite3_step(row), SQLITE_ROW) << sqlite3_errmsg(database);
  std::vector<double> values(static_cast<std::size_t>(sqlite3_column_bytes(row, 0)) / 8);
  if (!values.empty()) std::memcpy(values.data(), sqlite3_column_blob(row, 0), 8 * values.size());
  sqlite3_finalize(row);
  sqlite3_close(database);
  return values;
}

TEST(Colmap, APosePriorIsThePositionOfTheCameraWithItsCovariance) {
  ColmapModel model = two_frames();
  const std::string bytes = colmap_database(model);
  const ColmapFrame& frame = model.frames[0];
  const Vector3d p_imu = model.cameras[1].cam_T_imu.inverse().p;
  const auto position = [&](const Vector3d& theta, const Vector3d& dp) -> Vector3d {
    return so3::exp(theta) * frame.world_T_imu.R * p_imu + frame.world_T_imu.p + dp;
  };
  const auto found = blob_at(
      bytes, "SELECT position FROM pose_priors WHERE corr_data_id = 2 AND corr_sensor_id = 2");
  ASSERT_EQ(found.size(), 3);
  EXPECT_LT((Eigen::Map<const Vector3d>(found.data()) - position({0, 0, 0}, {0, 0, 0})).norm(),
            1e-12);
  // The covariance by a numeric derivative.
  Eigen::Matrix<double, 3, 6> J;
  constexpr double kStep = 1e-6;
  for (int k = 0; k < 6; ++k) {
    Vector6d step = Vector6d::Zero();
    step(k) = kStep;
    J.col(k) =
        (position(step.head<3>(), step.tail<3>()) - position(-step.head<3>(), -step.tail<3>())) /
        (2 * kStep);
  }
  const Eigen::Matrix3d expected = J * frame.pose_covariance * J.transpose();
  const auto covariance =
      blob_at(bytes, "SELECT position_covariance FROM pose_priors WHERE pose_prior_id = 2");
  ASSERT_EQ(covariance.size(), 9);
  EXPECT_LT((Eigen::Map<const Eigen::Matrix3d>(covariance.data()) - expected).norm(),
            1e-9 * expected.norm());
  // Gravity in the axes of the camera.
  const auto gravity = blob_at(bytes, "SELECT gravity FROM pose_priors WHERE pose_prior_id = 2");
  ASSERT_EQ(gravity.size(), 3);
  const SE3 cam_T_world = model.cameras[1].cam_T_imu * frame.world_T_imu.inverse();
  EXPECT_LT(
      (Eigen::Map<const Vector3d>(gravity.data()) - cam_T_world.R * Vector3d(0, 0, -1)).norm(),
      1e-12);
  model.is_level = false;
  EXPECT_TRUE(std::isnan(
      blob_at(colmap_database(model), "SELECT gravity FROM pose_priors WHERE pose_prior_id = 2")
          .at(0)));
}

TEST(Colmap, ASpaceInANameIsAnErrorInText) {
  ColmapModel model = two_frames();
  model.frames[1].images[0].name = "my walk/2.png";
  try {
    colmap_text(model);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("the image 'my walk/2.png' has a space in its name"),
              std::string::npos);
  }
  EXPECT_EQ(colmap_binary(model).size(), 5);
}

TEST(Colmap, ALensHasTheCoefficientsOfItsModel) {
  Camera camera = pinhole({});
  const auto lens = [&](Distortion distortion, const LensCoefficients& k) {
    camera.distortion = distortion;
    camera.coefficients = k;
    return colmap_lens(camera);
  };
  EXPECT_EQ(lens(Distortion::kRadtan, {1, 2, 3, 4}).name, "OPENCV");
  EXPECT_EQ(lens(Distortion::kRadtan, {0, 0, 0, 0}).name, "PINHOLE");
  const ColmapLens full = lens(Distortion::kRadtan, {1, 2, 3, 4, 5});
  EXPECT_EQ(full.name, "FULL_OPENCV");
  EXPECT_EQ(full.parameters, (std::vector<double>{500, 510, 320, 240, 1, 2, 3, 4, 5, 0, 0, 0}));
  EXPECT_EQ(lens(Distortion::kRadtan, {1, 2, 3, 4, 5, 6, 7, 8, 0, 0, 0, 0}).name, "FULL_OPENCV");
  EXPECT_EQ(lens(Distortion::kEquidistant, {1, 2, 3, 4}).parameters.size(), 8);
  EXPECT_EQ(lens(Distortion::kFisheye624, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}).parameters[15],
            12);
  const LensCoefficients prism{0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0};
  for (const auto& [distortion, found, k] :
       {std::tuple(Distortion::kDoubleSphere, "COLMAP has no lens model ds,",
                   LensCoefficients{0, 0.5}),
        std::tuple(Distortion::kOmni, "COLMAP has no lens model omni,", LensCoefficients{1}),
        std::tuple(Distortion::kRadtan, "COLMAP has no lens model radtan with prism terms,",
                   prism)}) {
    try {
      lens(distortion, k);
      FAIL() << found;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(found), std::string::npos) << error.what();
    }
  }
}

}  // namespace
}  // namespace chasles
