#include <algorithm>
#include <cmath>
#include <map>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <chasles/base/error.hpp>
#include <chasles/calibration/foreign_calibration.hpp>
#include <chasles/calibration/lens.hpp>
#include <chasles/codec/json_numbers.hpp>
#include <chasles/codec/numbers.hpp>

namespace chasles {
namespace {

namespace fs = std::filesystem;

constexpr double kCentimetre = 0.01;
constexpr int kLeftSocket = 1, kRightSocket = 2;  // CAM_B and CAM_C, unless the file states it

// A camera of the file by its socket.
using Sockets = std::map<int, JsonPlace>;

Sockets sockets_of(const JsonPlace& root) {
  Sockets sockets;
  const JsonPlace list = root.at("cameraData");
  for (std::size_t i = 0; i < list.size(); ++i) {
    const JsonPlace pair = list.at(i);
    sockets.emplace(static_cast<int>(pair.number(0)), pair.at(1));
  }
  return sockets;
}

Eigen::Matrix3d matrix_at(const JsonPlace& list) {
  Eigen::Matrix3d M;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      M(static_cast<int>(i), static_cast<int>(j)) = list.at(i).number(j);
    }
  }
  return M;
}

// An entry of extrinsics: it maps coordinates of its own frame to those of a camera.
struct Link {
  int to = -1;  // the camera's socket; negative: none
  SE3 to_T_from{};
};

Link link_of(const JsonPlace& extrinsics) {
  const int to = static_cast<int>(extrinsics.number("toCameraSocket"));
  if (to < 0) return {};
  const JsonPlace t = extrinsics.at("translation");
  const Eigen::Vector3d p(t.number("x"), t.number("y"), t.number("z"));
  const JsonPlace R = extrinsics.at("rotationMatrix");
  if (R.size() != 3) return {};
  return {.to = to, .to_T_from = {checked_rotation(R.where(), matrix_at(R)), kCentimetre * p}};
}

// The way from a camera along its links to the last one, and what maps to that.
struct Root {
  int socket = 0;
  SE3 root_T_camera;
};

Root root_of(const Sockets& sockets, int socket, const std::string& where) {
  Root root{.socket = socket, .root_T_camera = {}};
  for (std::size_t steps = 0; steps <= sockets.size(); ++steps) {
    const auto camera = sockets.find(root.socket);
    if (camera == sockets.end()) break;
    const Link link = link_of(camera->second.at("extrinsics"));
    if (link.to < 0) return root;
    root = {.socket = link.to, .root_T_camera = link.to_T_from * root.root_T_camera};
  }
  throw InputError(fmt::format("{}: the extrinsics of camera {} lead to no camera", where, socket));
}

// None where the file does not state it.
std::optional<SE3> cam_T_imu_of(const JsonPlace& json, const Sockets& sockets, int socket) {
  if (!json.has("imuExtrinsics")) return std::nullopt;
  const Link imu = link_of(json.at("imuExtrinsics"));
  // An EEPROM without it has zeros there.
  if (imu.to < 0 || !sockets.contains(imu.to)) return std::nullopt;
  const Root a = root_of(sockets, socket, json.where()), b = root_of(sockets, imu.to, json.where());
  if (a.socket != b.socket) return std::nullopt;
  return a.root_T_camera.inverse() * b.root_T_camera * imu.to_T_from;
}

// Up to 14 coefficients in OpenCV's order, of which the last two are those of a tilted sensor.
void set_depthai_distortion(const JsonPlace& entry, Camera& camera) {
  constexpr int kPerspective = 0, kFisheye = 1;
  const JsonPlace list = entry.at("distortionCoeff");
  const double type = entry.has("cameraType") ? entry.number("cameraType") : kPerspective;
  if (type != kPerspective && type != kFisheye) {
    throw InputError(fmt::format(
        "{}: cameraType is {:g}, a model that is not supported, expected 0 (perspective) or 1 "
        "(fisheye): calibrate with one of these",
        entry.where(), type));
  }
  std::vector<double> coefficients;
  for (std::size_t i = 0; i < list.size(); ++i) coefficients.push_back(list.number(i));
  const auto model = type == kFisheye ? Distortion::kEquidistant : Distortion::kRadtan;
  set_lens(list.where(), model, without_padding(model, coefficients), camera);
}

Camera depthai_lens(const JsonPlace& entry) {
  const JsonPlace K = entry.at("intrinsicMatrix");
  const Eigen::Matrix3d M = matrix_at(K);
  Camera camera{.width = checked_pixels(entry.where(), entry.number("width")),
                .height = checked_pixels(entry.where(), entry.number("height")),
                .fx = checked_positive(K.where(), M(0, 0)),
                .fy = checked_positive(K.where(), M(1, 1)),
                .cx = M(0, 2),
                .cy = M(1, 2),
                .cam_T_imu = {}};
  set_depthai_distortion(entry, camera);
  return camera;
}

std::vector<int> stereo_sockets(const JsonPlace& json) {
  if (!json.has("stereoRectificationData")) return {kLeftSocket, kRightSocket};
  const JsonPlace stereo = json.at("stereoRectificationData");
  const int left = static_cast<int>(stereo.number("leftCameraSocket")),
            right = static_cast<int>(stereo.number("rightCameraSocket"));
  return left < 0 || right < 0 ? std::vector{kLeftSocket, kRightSocket} : std::vector{left, right};
}

}  // namespace

KalibrCalibration read_depthai(const fs::path& file, const std::optional<fs::path>& imu,
                               std::size_t cameras) {
  const JsonFile json_file(file);
  const JsonPlace json = json_file.root();
  const Sockets sockets = sockets_of(json);
  if (!imu) {
    throw InputError(fmt::format(
        "{}: is a calibration of depthai, which states no noise of the IMU: expected an imu.yaml "
        "beside it with accelerometer_noise_density, accelerometer_random_walk, "
        "gyroscope_noise_density and gyroscope_random_walk",
        file.string()));
  }
  KalibrCalibration result = read_kalibr_imu(*imu);
  for (const int socket : stereo_sockets(json)) {
    const auto entry = sockets.find(socket);
    if (result.cameras.size() == cameras) continue;
    if (entry == sockets.end() && json.has("stereoRectificationData")) {
      throw InputError(
          fmt::format("{}: 'cameraData' has no camera at socket {}, expected those of "
                      "'stereoRectificationData'",
                      file.string(), socket));
    }
    if (entry == sockets.end()) continue;
    Camera camera = depthai_lens(entry->second);
    const auto cam_T_imu = cam_T_imu_of(json, sockets, socket);
    if (!cam_T_imu) {
      throw InputError(fmt::format(
          "{}: 'imuExtrinsics' is missing or zero, expected where the IMU is against the cameras: "
          "calibrate camera and IMU with kalibr_calibrate_imu_camera",
          file.string()));
    }
    camera.cam_T_imu = *cam_T_imu;
    result.cameras.push_back(camera);
  }
  if (result.cameras.empty()) {
    throw InputError(
        fmt::format("{}: 'cameraData' has neither the left nor the right camera", file.string()));
  }
  result.time_offsets.resize(result.cameras.size());
  result.camera_topics.resize(result.cameras.size());
  result.remarks.push_back(
      fmt::format("the calibration is that of {} (depthai: the left camera is cam0), and of {}",
                  file.filename().string(), imu->filename().string()));
  return result;
}

}  // namespace chasles
